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

from lgmd2jax import _medulla as medulla, _retina as retina
from lgmd2jax._low_pass import coefficient, low_pass
from lgmd2jax._pool import pool
from lgmd2jax._retina import Map

Scalar = Float[Array, ""]


class PixelState(eqx.Module):
    """What the pixels keep from one frame to the next. It is pointwise in space: neighbours only feed forward."""

    luminance: Map
    p: Float[Array, "n_p row col"]
    on: Map
    off: Map
    d_on: Map
    d_off: Map

    @classmethod
    def rest(cls, frame: Map, n_p: int) -> "PixelState":
        """At rest, with `frame` as what was seen before."""
        zero = jnp.zeros_like(frame)
        return cls(frame, jnp.zeros((n_p, *frame.shape), frame.dtype), zero, zero, zero, zero)


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


def pixel_step(model, state: PixelState, frame: Map, interval) -> tuple[PixelState, tuple[Scalar, Scalar, Layers]]:
    """Eqs 1-11 and 13: the next state of the pixels; MP, F and the layers of this frame."""
    state, p, f = remember(model, state, frame, interval)
    spread_on, spread_off = medulla.lateral(state.d_on), medulla.lateral(state.d_off)
    s, s_on, s_off = sum_flows(model, state.on, state.off, spread_on, spread_off)
    mp, s_gated = gate_and_pool(model, s)
    g = medulla.g_layer(s_gated)
    layers = Layers(p, state.on, state.off, state.d_on, state.d_off, s_on, s_off, s, s_gated, g)
    return state, (mp, f, layers)


def remember(model, state: PixelState, frame: Map, interval) -> tuple[PixelState, Map, Scalar]:
    """Eqs 1-4 and 13, all that has a memory, each pixel by itself: the next state, P and F."""
    parameters, interval = cast((model.parameters, interval), frame.dtype)
    a = coefficient(parameters.tau1, interval, model.low_pass)

    p = retina.photoreceptors(frame, state.luminance, state.p, parameters.u)
    on, off = retina.half_wave(p)
    on = retina.residual(on, state.on, parameters.sigma1)
    off = retina.residual(off, state.off, parameters.sigma1)
    d_on = low_pass(state.d_on, on, a)
    d_off = low_pass(state.d_off, off, a)

    history = jnp.concatenate([p[None], state.p])[: model.n_p]
    return PixelState(frame, history, on, off, d_on, d_off), p, pool(retina.magnitude(p), 1 / p.size)


def sum_flows(model, on: Map, off: Map, spread_on: Map, spread_off: Map) -> tuple[Map, Map, Map]:
    """Eqs 7 and 8: S, and S_on and S_off on the way to it."""
    parameters = cast(model.parameters, on.dtype)
    s_on, s_off = medulla.local_sums(on, off, spread_on, spread_off, parameters.w_bias)
    return medulla.s_layer(s_on, s_off, parameters), s_on, s_off


def gate_and_pool(model, s: Map) -> tuple[Scalar, Map]:
    """Eqs 9 and 11: MP, and S' on the way to it."""
    s_gated = medulla.gate(s, model.parameters.T_s.astype(s.dtype), model.thresholds)
    return pool(s_gated), s_gated


def cast(tree, dtype):
    """All leaves in this dtype."""
    return jax.tree.map(lambda leaf: leaf.astype(dtype), tree)
