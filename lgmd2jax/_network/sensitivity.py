"""The exact derivative of the pixel stage with respect to its parameters, in one pass forward over the frames.

What a pixel remembers depends on that pixel alone, and of every frame only two sums over the field are kept, MP and F.
So a parameter needs one map of sensitivities for each array of the state that depends on it, carried along with the
state: forward mode over time. A parameter without memory needs no map at all. Within a frame it is forward mode up to
S, whose derivative is multiplied by the slope of MP in S, one map for all parameters, and added up.

Nothing here repeats an equation of the network. JAX differentiates the four parts of the stage (`parts`), and which
part and which state depend on which parameter is read from the result: `equinox.filter_jvp` returns None for no change.
"""

import functools
import operator
from collections.abc import Iterable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Real

from lgmd2jax._network.maps import Bordered, pool
from lgmd2jax._network.parameter_set import declared
from lgmd2jax._network.parts import PixelParts, Traces, mp_of, signals_of
from lgmd2jax._network.stages import Interval, Sums
from lgmd2jax._network.tiles import DERIVED, FORWARD, change, over_tiles
from lgmd2jax._types import Scalar

Rows = dict[str, Array | None]  # the derivative by each parameter, None for no influence


def exact_sums(pixels: PixelParts, frames: Real[Array, "time row col"], interval: Interval) -> Sums:
    """MP(t) and F(t) over a clip.

    `jax.grad`, `jax.jacfwd`, `jax.linearize` and all that builds on them use the sensitivities without knowing: the
    tangents of the parameters are multiplied by the Jacobian, which is computed once however many tangents there are.
    Where something else is perturbed (frames, interval, temperature, widths) JAX differentiates the plain loop.
    """
    return _exact_sums(pixels, frames, interval)


@eqx.filter_custom_jvp
def _exact_sums(pixels: PixelParts, frames, interval) -> Sums:
    return _tiled(pixels, frames, interval, ())[0]


@_exact_sums.def_jvp
def _exact_sums_jvp(primals, tangents):
    pixels, frames, interval = primals
    pixels_tangent, *input_tangents = tangents
    other_tangents = eqx.tree_at(lambda stage: stage.parameters, pixels_tangent, None), input_tangents
    if jax.tree.leaves(other_tangents):
        return eqx.filter_jvp(lambda stage, *inputs: stage.plain(*inputs)[0], primals, tangents)
    names = declared(type(pixels.parameters))
    perturbed = {name: getattr(pixels_tangent.parameters, name) for name in names}
    perturbed = {name: tangent for name, tangent in perturbed.items() if tangent is not None}
    sums, jacobian = _tiled(pixels, frames, interval, tuple(perturbed))

    def tangent(value, rows: Rows):
        return _total(row * perturbed[name].astype(value.dtype) for name, row in rows.items() if row is not None)

    along: Iterable[Any] = map(tangent, sums, jacobian)  # None where nothing changes
    return sums, Sums(*along)


def _tiled(pixels: PixelParts, frames, interval, names: tuple[str, ...]) -> tuple[Sums, tuple[Rows, Rows]]:
    """The sums over a clip, and the derivatives of MP and of F by the named parameters, from those of the tiles.

    MP is a sum over the field and F a mean.
    """
    of_tile = functools.partial(_scan, pixels, frames, interval, names)
    (mp, f), (mp_rows, f_rows) = over_tiles(of_tile, frames, maps=DERIVED if names else FORWARD)
    mp, mp_rows = jax.tree.map(lambda of_tiles: of_tiles.sum(axis=0), (mp, mp_rows))
    f, f_rows = jax.tree.map(lambda of_tiles: of_tiles.mean(axis=0), (f, f_rows))
    return Sums(mp, f), (mp_rows, f_rows)


class _Carry(NamedTuple):
    """What goes from frame to frame: the traces, their sensitivities by parameter, and a map to write over."""

    traces: Traces
    sensitivities: dict[str, Traces]
    border: Bordered


def _scan(pixels: PixelParts, frames, interval, names: tuple[str, ...], first, height: int):
    """The same of one tile: `height` rows from row `first` on."""

    def step(carry: _Carry, t):
        border = change(frames, t, first, onto=carry.border)
        own = interval[t] if interval.ndim else interval

        def advance(pixels, traces):
            traces, f, _ = pixels.remember(traces, border, own)
            return traces, f

        traces, f = advance(pixels, carry.traces)
        signals = signals_of(traces)
        s = pixels.add_flows(signals)
        tired = pixels.tire(traces, s, own)
        if not names:
            return _Carry(tired, {}, border), (Sums(pixels.gate_and_pool(s), f), ({}, {}))
        of_advance = _linearised(advance, pixels, carry.traces)
        s_gated, to_s = jax.vjp(pixels.gate, s)
        mp, (by_s,) = mp_of(s_gated), to_s(jnp.ones_like(s))

        def derivatives(name: str) -> tuple[Traces, Scalar | None, Scalar | None]:
            """Of the traces, MP and F."""
            unit = _unit(pixels, name)
            maps, df = of_advance(unit, carry.sensitivities[name])
            along = unit, signals_of(maps)  # linear in the traces, so that it is its own derivative
            _, ds = eqx.filter_jvp(lambda stage, signals: stage.add_flows(signals), (pixels, signals), along)
            _, dmp = eqx.filter_jvp(lambda stage: stage.gate_and_pool(s), (pixels,), (unit,))
            _, maps = eqx.filter_jvp(lambda stage, *of: stage.tire(*of, own), (pixels, traces, s), (unit, maps, ds))
            return maps, _total((dmp, None if ds is None else pool(by_s * ds))), df

        every = {name: derivatives(name) for name in names}
        maps = {name: of_traces for name, (of_traces, _, _) in every.items()}
        mp_rows: Rows = {name: of_mp for name, (_, of_mp, _) in every.items()}
        f_rows: Rows = {name: of_f for name, (_, _, of_f) in every.items()}
        return _Carry(tired, maps, border), (Sums(mp, f), (mp_rows, f_rows))

    rest = pixels.traces_at_rest(frames[0, :height].astype(interval.dtype))
    maps = {name: _maps_at_rest(pixels, name, rest, interval) for name in names}
    return jax.lax.scan(step, _Carry(rest, maps, rest.on), jnp.arange(len(frames)))[1]


def _linearised(function, *inputs):
    """The derivative of a function at these inputs, by tangents of which some are None, as in `equinox.filter_jvp`."""
    arrays, rest = eqx.partition(inputs, eqx.is_array)
    _, linear = jax.linearize(lambda arrays: function(*eqx.combine(arrays, rest)), arrays)
    zeros = jax.tree.map(jnp.zeros_like, arrays)

    def derivative(*tangents):
        return eqx.filter_jvp(linear, (zeros,), (tangents,))[1]

    return derivative


def _unit(pixels: PixelParts, name: str):
    """A tangent of the stage: 1 for this parameter, None for all else."""
    nothing = jax.tree.map(lambda _: None, pixels)
    one = np.ones((), getattr(pixels.parameters, name).dtype)
    return eqx.tree_at(lambda stage: getattr(stage.parameters, name), nothing, one, is_leaf=lambda leaf: leaf is None)


def _maps_at_rest(pixels: PixelParts, name: str, rest: Traces, interval: Interval) -> Any:
    """Sensitivities of traces at rest: 0 for the arrays that this parameter will reach, None for the others."""
    own = interval[0] if interval.ndim else interval

    def reach(maps):
        def advance(pixels, traces):
            traces, _, _ = pixels.remember(traces, rest.on, own)
            return pixels.tire(traces, pixels.add_flows(signals_of(traces)), own)

        return eqx.filter_jvp(advance, (pixels, rest), (_unit(pixels, name), maps))[1]

    maps, reached = None, jax.tree.map(lambda _: None, rest)
    while jax.tree.structure(maps) != jax.tree.structure(reached):
        maps = jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), reached)
        reached = eqx.filter_eval_shape(reach, maps)
    return maps


def _total(parts: Iterable[Array | None]) -> Array | None:
    """The sum of what there is; None where there is nothing."""
    present = [part for part in parts if part is not None]
    return functools.reduce(operator.add, present) if present else None
