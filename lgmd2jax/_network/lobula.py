"""The lobula: the LGMD cell (eqs 12-17). It sees two numbers a frame, MP and F, and keeps a handful of state."""

import dataclasses
import math

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._network.low_pass import LowPass, coefficient, low_pass
from lgmd2jax._network.parameter_set import declared
from lgmd2jax._network.parameters import Parameters
from lgmd2jax._network.retina import magnitude
from lgmd2jax._network.stages import AbstractCell, Interval, Response, Sums
from lgmd2jax._network.thresholds import Thresholds
from lgmd2jax._types import Scalar

_SMALL = 1e-3  # of the excitation, at which its power has a finite slope
_LEAST = 1e-12  # added to Fbar, whose logarithm is then finite
_REFERENCE_MS = 1000 / 30  # of change per time: a frame of the robot's camera, for which the paper states Table I


class Past(eqx.Module):
    """The sums of the last frames, the newest first, and how long ago each was, in ms; infinity for what never was."""

    age: Float[Array, " past"]
    sums: Sums


class CellState(eqx.Module):
    """What the cell keeps from one frame to the next: Fbar, U, U' and the spikes of the last N_ts frames.

    `excitation`: of the membrane, x. `past`: what a lag needs of a stream. None without these mechanisms.
    """

    ffi: Scalar
    u: Scalar
    u_adapted: Scalar
    spikes: Float[Array, " N_ts"]
    excitation: Scalar | None = None
    past: Past | None = None


class Cell(AbstractCell):
    """From MP and F to spikes and alarm: per time, lag, inhibition, gate or shunt, membrane, adaptation, spikes.

    `inhibited_from`: the threshold of the inhibition, T_ffi or A_ffi. `shortest_interval`: ms, in steps of which a lag
    is kept.
    """

    parameters: Parameters
    thresholds: Thresholds
    low_pass: LowPass = eqx.field(static=True)
    N_ts: int = eqx.field(static=True)
    mechanisms: tuple[str, ...] = eqx.field(static=True)
    shortest_interval: float = eqx.field(static=True)

    @property
    def inhibited_from(self) -> Scalar:
        return self.parameters.A_ffi if "size" in self.mechanisms else self.parameters.T_ffi

    def rest(self) -> CellState:
        """Fbar(-1) = 0, U(-1) = U'(-1) = .5, x(-1) = 0, no spikes, no past."""
        dtype = self.parameters.dtype
        zero, half = jnp.zeros((), dtype), jnp.full((), 0.5, dtype)
        excitation = zero if "membrane" in self.mechanisms else None
        past = self._no_past(dtype) if "lag" in self.mechanisms else None
        return CellState(zero, half, half, jnp.zeros(self.N_ts, dtype), excitation, past)

    def step(self, state: CellState, sums: Sums, interval: Scalar, pixels: int) -> tuple[CellState, Response]:
        """Eqs 12-17 in the order of the paper."""
        past, late = None, self._per_time(sums, interval)
        if state.past is not None:
            past = _remembered(state.past, late, interval)
            late = _delayed(past, self.parameters.lag)
        state, response = self._react(state, late, interval, pixels)
        return eqx.tree_at(lambda s: s.past, state, past, is_leaf=lambda leaf: leaf is None), _as_seen(response, sums)

    def over(self, sums: Sums, interval: Interval, pixels: int) -> Response:
        """The same for a clip. By a steady clock the past is a shift, which need not be carried along."""
        if "lag" not in self.mechanisms or interval.ndim:
            return super().over(sums, interval, pixels)
        late = Sums(*(_shifted(channel, self.parameters.lag / interval) for channel in sums))
        without = dataclasses.replace(self, mechanisms=tuple(name for name in self.mechanisms if name != "lag"))
        return _as_seen(without.over(late, interval, pixels), sums)

    def _per_time(self, sums: Sums, interval: Scalar) -> Sums:
        """The sums as they would be of a frame of the reference's length. A share of the field is not a change."""
        if "rate" not in self.mechanisms:
            return sums
        scale = _REFERENCE_MS / interval
        return Sums(scale * sums.mp, sums.f if "size" in self.mechanisms else scale * sums.f)

    def _react(self, state: CellState, sums: Sums, interval: Scalar, pixels: int) -> tuple[CellState, Response]:
        v = self.parameters
        ffi = low_pass(state.ffi, sums.f, coefficient(v.tau2, interval, self.low_pass))
        drive, excitation = magnitude(sums.mp) / (pixels * v.k), None
        if "shunt" in self.mechanisms:
            excitation = shunted(drive, ffi, self.inhibited_from, v.m, v.gamma)
            if state.excitation is not None:
                excitation = low_pass(state.excitation, excitation, coefficient(v.tau_cell, interval, self.low_pass))
            u = jax.nn.sigmoid(excitation)
        else:
            u = gated(drive, self.thresholds.ffi(ffi, self.inhibited_from))
        u_adapted = self._adapted(u, state, interval)
        spikes = self.thresholds.spikes(u_adapted, v.T_sp, v.sigma_sp)
        window = jnp.append(state.spikes, spikes)
        collision = self.thresholds.collision(window.sum(), v.N_sp)
        kept = None if state.excitation is None else excitation
        state = CellState(ffi, u, u_adapted, window[1:], kept, state.past)
        return state, Response(sums.mp, ffi, u, u_adapted, spikes, collision)

    def _adapted(self, u: Scalar, state: CellState, interval: Scalar) -> Scalar:
        """Eq. 15: U' = c (U'(t-1) + d) where d = U - U(t-1) <= T_sfa, else c U; then at least .5.

        c = tau3/(tau3 + ti).
        """
        c = self.parameters.tau3 / (self.parameters.tau3 + interval)
        rise = u - state.u
        adapts = self.thresholds.sfa(rise, self.parameters.T_sfa)
        return self.thresholds.floor(c * (u + adapts * (state.u_adapted + rise - u)))

    def _no_past(self, dtype) -> Past:
        """Long enough for any lag."""
        _, longest = declared(Parameters)["lag"].limits
        length = math.ceil(longest / self.shortest_interval) + 2
        nothing = jnp.zeros(length, dtype)
        return Past(jnp.full(length, jnp.inf, dtype), Sums(nothing, nothing))


def gated(drive: Scalar, gate: Scalar) -> Scalar:
    """Eq. 12 behind the feed-forward gate: U = .5 + gate (1/(1 + exp(-d)) - .5), in [.5, 1), d = abs(MP)/(n k).

    The gate acts on the cell's excitation, not on MP: a saturated MP would leak through a soft gate whole.
    """
    return 0.5 + gate * (jax.nn.sigmoid(drive) - 0.5)


def shunted(drive: Scalar, ffi: Scalar, threshold: Scalar, m: Scalar, gamma: Scalar) -> Scalar:
    """The excitation x = ((d + eps)^gamma - eps^gamma)/(1 + (Fbar/A)^m), by logarithms, which do not overflow."""
    power = (drive + _SMALL) ** gamma - _SMALL**gamma
    return power * jax.nn.sigmoid(m * (jnp.log(threshold) - jnp.log(ffi + _LEAST)))


def _shifted(channel: Float[Array, " time"], frames: Scalar) -> Float[Array, " time"]:
    """The channel so many frames late, linear between them, 0 before the first one."""
    whole = jnp.floor(frames)
    rest, index = frames - whole, jnp.arange(len(channel)) - whole.astype(int)
    newer, older = (jnp.where(place >= 0, channel[jnp.maximum(place, 0)], 0) for place in (index, index - 1))
    between = jnp.where(rest > 0, newer + rest * (older - newer), newer)  # NaN stays where it is
    return jnp.where(index - (rest > 0) < 0, 0, between)


def _remembered(past: Past, sums: Sums, interval: Scalar) -> Past:
    """The past one frame later, with the sums of this frame."""
    age = jnp.concatenate([jnp.zeros_like(past.age[:1]), past.age[:-1] + interval])
    return Past(age, Sums(*(jnp.concatenate([now[None], old[:-1]]) for now, old in zip(sums, past.sums, strict=True))))


def _delayed(past: Past, lag: Scalar) -> Sums:
    """The sums of `lag` ms ago, linear between frames; 0 before the first one, NaN where they are forgotten."""
    known = jnp.isfinite(past.age)
    oldest, beyond = jnp.max(jnp.where(known, past.age, 0)), jnp.where(known[-1], jnp.nan, 0.0)
    age = jnp.where(known, past.age, oldest + 1 + jnp.arange(len(past.age)))
    return Sums(
        *(jnp.where(lag > oldest, beyond.astype(channel.dtype), jnp.interp(lag, age, channel)) for channel in past.sums)
    )


def _as_seen(response: Response, sums: Sums) -> Response:
    """The response with MP as the pixels sum it: of this frame, and by none but its own interval."""
    return eqx.tree_at(lambda response: response.mp, response, sums.mp)
