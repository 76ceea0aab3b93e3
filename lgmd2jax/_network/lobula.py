"""The lobula: the LGMD cell (eqs 12-17). It sees two numbers a frame, MP and F, and keeps a handful of state."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._network.low_pass import LowPass, coefficient, low_pass
from lgmd2jax._network.parameters import Parameters
from lgmd2jax._network.retina import magnitude
from lgmd2jax._network.thresholds import Thresholds
from lgmd2jax._types import Scalar


class CellState(eqx.Module):
    """What the cell keeps from one frame to the next: Fbar, U, U' and the spikes of the last N_ts frames."""

    ffi: Scalar
    u: Scalar
    u_adapted: Scalar
    spikes: Float[Array, " N_ts"]

    @classmethod
    def rest(cls, N_ts: int, dtype) -> "CellState":
        """Fbar(-1) = 0, U(-1) = U'(-1) = .5, no spikes."""
        half = jnp.full((), 0.5, dtype)
        return cls(jnp.zeros((), dtype), half, half, jnp.zeros(N_ts, dtype))


def membrane_potential(mp: Scalar, gate: Scalar, pixels: int, k: Scalar) -> Scalar:
    """Eq. 12 behind the feed-forward gate: U = .5 + gate (1/(1 + exp(-abs(MP)/(n k))) - .5), in [.5, 1).

    The gate acts on the cell's excitation, not on MP: a saturated MP would leak through a soft gate whole.
    """
    return 0.5 + gate * (jax.nn.sigmoid(magnitude(mp) / (pixels * k)) - 0.5)


def adaptation(u: Scalar, state: CellState, parameters: Parameters, thresholds: Thresholds, interval: Scalar) -> Scalar:
    """Eq. 15: U' = c (U'(t-1) + d) where d = U - U(t-1) <= T_sfa, else c U; then at least .5. c = tau3/(tau3 + ti)."""
    c = parameters.tau3 / (parameters.tau3 + interval)
    rise = u - state.u
    adapts = thresholds.sfa(rise, parameters.T_sfa)
    return thresholds.floor(c * (u + adapts * (state.u_adapted + rise - u)))


def cell_step(
    state: CellState,
    mp: Scalar,
    f: Scalar,
    parameters: Parameters,
    thresholds: Thresholds,
    interval: Scalar,
    pixels: int,
    form: LowPass,
) -> tuple[CellState, dict[str, Scalar]]:
    """One frame of the cell: eqs 12-17 in the order of the paper.

    **Arguments:** `mp` the summed potential (eq. 11), `f` the mean change of luminance (eq. 13), both in grey levels;
    `interval` in ms; `pixels` the n of eq. 12; `form` how eq. 14 is discretised.

    **Returns:** the next state, and the cell's channels by name.
    """
    ffi = low_pass(state.ffi, f, coefficient(parameters.tau2, interval, form))
    u = membrane_potential(mp, thresholds.ffi(ffi, parameters.T_ffi), pixels, parameters.k)
    u_adapted = adaptation(u, state, parameters, thresholds, interval)
    spikes = thresholds.spikes(u_adapted, parameters.T_sp, parameters.sigma_sp)
    window = jnp.append(state.spikes, spikes)
    collision = thresholds.collision(window.sum(), parameters.N_sp)
    channels = {"mp": mp, "ffi": ffi, "smp": u, "smp_adapted": u_adapted, "spikes": spikes, "collision": collision}
    return CellState(ffi, u, u_adapted, window[1:]), channels
