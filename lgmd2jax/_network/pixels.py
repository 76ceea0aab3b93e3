"""The pixel stage: from frames to MP(t) and F(t), the only two numbers of a frame that the cell sees.

A step has three parts, by what a derivative needs of each (`_sensitivity`): what pixels remember, how flows add up to
S, and the gate with the sum over the field. Each takes the `LGMD2` whose parameters and structure it uses.
"""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._network import medulla, retina
from lgmd2jax._network.low_pass import coefficient, low_pass
from lgmd2jax._network.maps import Bordered, bordered, inside, pool
from lgmd2jax._types import Map, Scalar, cast


class Traces(eqx.Module):
    """What the pixels remember of changes, with the border. It is pointwise: neighbours only feed forward."""

    p: Float[Array, "n_p row_and_border col_and_border"]
    on: Bordered
    off: Bordered
    d_on: Bordered
    d_off: Bordered

    @classmethod
    def rest(cls, frame: Map, n_p: int) -> "Traces":
        """Those of pixels that saw no change."""
        zero = jnp.zeros((frame.shape[0] + 2, frame.shape[1] + 2), frame.dtype)
        return cls(jnp.zeros((n_p, *zero.shape), zero.dtype), zero, zero, zero, zero)


class PixelState(eqx.Module):
    """What the pixels keep from one frame to the next."""

    luminance: Map
    traces: Traces


class Layers(eqx.Module):
    """The maps of one frame, in grey levels, for `record` to choose from."""

    p: Map
    on: Map
    off: Map
    d_on: Map
    d_off: Map
    s_on: Map
    s_off: Map
    s: Map
    s_gated: Map
    g: Map


Record = Callable[[Layers], Any]


def scan_pixels(model, frames, interval, record: Record | None) -> tuple[Array, Array, Any]:
    """MP(t), F(t) and what was recorded, over a clip, of any `Network`."""

    def step(state, frame):
        state, (mp, f, layers) = model._pixel_step(state, frame, interval)
        return state, (mp, f, None if record is None else record(layers))

    return jax.lax.scan(step, model._pixels_at_rest(frames[0]), frames)[1]


def scan_sums(model, frames, interval) -> tuple[Array, Array]:
    """MP(t) and F(t) of an `LGMD2` over a clip, the numbers of `scan_pixels` with fewer copies.

    Frames are read where they lie rather than carried, and the border is laid in place. The reverse derivative by the
    frames would add up over whole clips, so that `scan_pixels` serves that one.
    """

    def step(carry, t):
        traces, border = carry
        border = bordered(change(frames, t), onto=border)
        traces, p = remember(model, traces, border, interval)
        mp, f, _ = sums(model, traces, p)
        return (traces, border), (mp, f)

    traces = Traces.rest(frames[0], model.n_p)
    return jax.lax.scan(step, (traces, traces.on), jnp.arange(len(frames)))[1]


def change(frames, t) -> Map:
    """L(t) - L(t-1), with the first frame as what was seen before."""
    return frames[t] - frames[jnp.maximum(t - 1, 0)]


def pixel_step(model, state: PixelState, frame: Map, interval) -> tuple[PixelState, tuple[Scalar, Scalar, Layers]]:
    """Eqs 1-11 and 13: the next state of the pixels; MP, F and the layers of this frame."""
    traces, p = remember(model, state.traces, bordered(frame - state.luminance), interval)
    return PixelState(frame, traces), sums(model, traces, p)


def remember(model, traces: Traces, change: Bordered, interval) -> tuple[Traces, Bordered]:
    """Eqs 1-4, all that has a memory, each pixel by itself: the next traces, and P."""
    parameters, interval = cast((model.parameters, interval), change.dtype)
    a = coefficient(parameters.tau1, interval, model.low_pass)

    p = retina.photoreceptors(change, traces.p, parameters.u)
    on, off = retina.half_wave(p)
    on = retina.residual(on, traces.on, parameters.sigma1)
    off = retina.residual(off, traces.off, parameters.sigma1)
    d_on = low_pass(traces.d_on, on, a)
    d_off = low_pass(traces.d_off, off, a)

    history = jnp.concatenate([p[None], traces.p])[: model.n_p]
    return Traces(history, on, off, d_on, d_off), p


def sums(model, traces: Traces, p: Bordered) -> tuple[Scalar, Scalar, Layers]:
    """Eqs 5-11 and 13: MP and F of a frame, and the layers on the way to them."""
    on, off, p = inside(traces.on), inside(traces.off), inside(p)
    spread_on, spread_off = medulla.lateral(traces.d_on), medulla.lateral(traces.d_off)
    s, s_on, s_off = sum_flows(model, on, off, spread_on, spread_off)
    mp, s_gated = gate_and_pool(model, s)
    g = medulla.g_layer(bordered(s_gated))
    layers = Layers(p, on, off, inside(traces.d_on), inside(traces.d_off), s_on, s_off, s, s_gated, g)
    return mp, mean_change(p), layers


def mean_change(p: Map) -> Scalar:
    """Eq. 13: F, the mean of abs(P)."""
    return pool(retina.magnitude(p), 1 / p.size)


def sum_flows(model, on: Map, off: Map, spread_on: Map, spread_off: Map) -> tuple[Map, Map, Map]:
    """Eqs 7 and 8: S, and S_on and S_off on the way to it."""
    parameters = cast(model.parameters, on.dtype)
    s_on, s_off = medulla.local_sums(on, off, spread_on, spread_off, parameters.w_bias)
    return medulla.s_layer(s_on, s_off, parameters), s_on, s_off


def gate_and_pool(model, s: Map) -> tuple[Scalar, Map]:
    """Eqs 9 and 11: MP, and S' on the way to it."""
    s_gated = medulla.gate(s, model.parameters.T_s.astype(s.dtype), model.thresholds)
    return pool(s_gated), s_gated
