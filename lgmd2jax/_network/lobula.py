"""The lobula: the LGMD cell (eqs 12-17). It sees two numbers a frame, MP and F, and keeps a handful of state."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._network.low_pass import LowPass, coefficient, low_pass
from lgmd2jax._network.parameters import Parameters
from lgmd2jax._network.retina import magnitude
from lgmd2jax._network.stages import AbstractCell, Response, Sums
from lgmd2jax._network.thresholds import Thresholds
from lgmd2jax._types import Scalar


class CellState(eqx.Module):
    """What the cell keeps from one frame to the next: Fbar, U, U' and the spikes of the last N_ts frames."""

    ffi: Scalar
    u: Scalar
    u_adapted: Scalar
    spikes: Float[Array, " N_ts"]


class Cell(AbstractCell):
    """From MP and F to spikes and alarm."""

    parameters: Parameters
    thresholds: Thresholds
    low_pass: LowPass = eqx.field(static=True)
    N_ts: int = eqx.field(static=True)

    def rest(self) -> CellState:
        """Fbar(-1) = 0, U(-1) = U'(-1) = .5, no spikes."""
        dtype = self.parameters.dtype
        half = jnp.full((), 0.5, dtype)
        return CellState(jnp.zeros((), dtype), half, half, jnp.zeros(self.N_ts, dtype))

    def step(self, state: CellState, sums: Sums, interval: Scalar, pixels: int) -> tuple[CellState, Response]:
        """Eqs 12-17 in the order of the paper."""
        v = self.parameters
        ffi = low_pass(state.ffi, sums.f, coefficient(v.tau2, interval, self.low_pass))
        u = membrane_potential(sums.mp, self.thresholds.ffi(ffi, v.T_ffi), pixels, v.k)
        u_adapted = self._adaptation(u, state, interval)
        spikes = self.thresholds.spikes(u_adapted, v.T_sp, v.sigma_sp)
        window = jnp.append(state.spikes, spikes)
        collision = self.thresholds.collision(window.sum(), v.N_sp)
        return CellState(ffi, u, u_adapted, window[1:]), Response(sums.mp, ffi, u, u_adapted, spikes, collision)

    def _adaptation(self, u: Scalar, state: CellState, interval: Scalar) -> Scalar:
        """Eq. 15: U' = c (U'(t-1) + d) where d = U - U(t-1) <= T_sfa, else c U; then at least .5.

        c = tau3/(tau3 + ti).
        """
        c = self.parameters.tau3 / (self.parameters.tau3 + interval)
        rise = u - state.u
        adapts = self.thresholds.sfa(rise, self.parameters.T_sfa)
        return self.thresholds.floor(c * (u + adapts * (state.u_adapted + rise - u)))


def membrane_potential(mp: Scalar, gate: Scalar, pixels: int, k: Scalar) -> Scalar:
    """Eq. 12 behind the feed-forward gate: U = .5 + gate (1/(1 + exp(-abs(MP)/(n k))) - .5), in [.5, 1).

    The gate acts on the cell's excitation, not on MP: a saturated MP would leak through a soft gate whole.
    """
    return 0.5 + gate * (jax.nn.sigmoid(magnitude(mp) / (pixels * k)) - 0.5)
