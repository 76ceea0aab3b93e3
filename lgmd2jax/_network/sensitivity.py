"""The exact derivative of the pixel stage with respect to its parameters, in one pass forward over the frames.

What a pixel remembers depends on that pixel alone, and of every frame only two sums over the field are kept, MP and F.
So a parameter needs one map of sensitivities for each array of the state that depends on it, carried along with the
state: forward mode over time. MP is one number, so that its slopes in all signals of a frame come from one backward
pass over that frame: reverse mode within a frame. A parameter without memory needs no map at all.

Nothing here repeats an equation of the network. JAX differentiates the three parts of `pixel_step`, and which part
and which state depend on which parameter is read from what it finds: `equinox.filter_jvp` returns None for no change.
"""

import functools
import operator
from collections.abc import Iterable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from lgmd2jax._network.maps import bordered, inside, pool
from lgmd2jax._network.medulla import lateral
from lgmd2jax._network.parameters import symbols
from lgmd2jax._network.pixels import (
    Record,
    Traces,
    change,
    gate_and_pool,
    mean_change,
    remember,
    scan_pixels,
    scan_sums,
    sum_flows,
)
from lgmd2jax._types import cast


def potentials(model, frames, interval, record: Record | None = None) -> tuple[Array, Array, Any]:
    """The pixel stage of an `LGMD2` over a clip: MP(t), F(t) and what was recorded.

    `jax.grad`, `jax.jacfwd`, `jax.linearize` and all that builds on them use the sensitivities without knowing: the
    tangents of the parameters are multiplied by the Jacobian, which is computed once however many tangents there are.
    Where something else is perturbed (frames, interval, temperature, widths), and with `record`, JAX differentiates the
    scan as it stands.
    """
    if record is None:
        return *_potentials(model, frames, interval), None
    return scan_pixels(model, frames, interval, record)


_potentials = eqx.filter_custom_jvp(scan_sums)


@_potentials.def_jvp
def _potentials_jvp(primals, tangents):
    model, frames, interval = primals
    model_tangent, *input_tangents = tangents
    other_tangents = eqx.tree_at(lambda model: model.parameters, model_tangent, None), input_tangents
    if jax.tree.leaves(other_tangents):
        return eqx.filter_jvp(lambda *inputs: scan_pixels(*inputs, record=None)[:2], primals, tangents)
    all_tangents = {name: getattr(model_tangent.parameters, name) for name in symbols()}
    perturbed = {name: tangent for name, tangent in all_tangents.items() if tangent is not None}
    outputs, jacobian = _sensitivities(model, frames, interval, tuple(perturbed))

    def moved(output, rows):
        return _total(row * perturbed[name].astype(output.dtype) for name, row in rows.items() if row is not None)

    return outputs, tuple(map(moved, outputs, jacobian))


def _sensitivities(model, frames, interval, names: tuple[str, ...]):
    """MP(t) and F(t), and for each a dictionary of its derivatives by the named parameters, None for no influence."""
    model = eqx.tree_at(lambda model: model.parameters, model, cast(model.parameters, frames.dtype))
    start = Traces.rest(frames[0], model.n_p)

    def step(carry, t):
        traces, maps, borders = carry
        border = bordered(change(frames, t), onto=borders[0])

        def advance(model, traces):
            traces, p = remember(model, traces, border, interval)
            return traces, mean_change(inside(p))

        new, f = advance(model, traces)
        signals = inside(new.on), inside(new.off), lateral(new.d_on), lateral(new.d_off)
        s, to_signals = jax.vjp(lambda signals: sum_flows(model, *signals)[0], signals)
        # Linearised once for all parameters: XLA would compute the slope of the gate anew for each.
        mp, of_s = jax.linearize(lambda s: gate_and_pool(model, s)[0], s)
        ((on, off, *spreads),) = to_signals(*jax.linear_transpose(of_s, s)(jnp.ones_like(mp)))
        # The lateral spread is its own adjoint, so two spreads a frame serve the maps of all parameters.
        spreads = [bordered(spread, onto) for spread, onto in zip(spreads, borders[1:], strict=True)]
        d_on, d_off = map(lateral, spreads)
        slopes = {"on": on, "off": off, "d_on": d_on, "d_off": d_off}

        def rows_of(name):
            unit = _unit(model, name)
            _, (new_maps, df) = eqx.filter_jvp(advance, (model, traces), (unit, maps[name]))
            _, ds = eqx.filter_jvp(lambda model: sum_flows(model, *signals)[0], (model,), (unit,))
            _, dmp = eqx.filter_jvp(lambda model: gate_and_pool(model, s)[0], (model,), (unit,))
            moved = {field: getattr(new_maps, field) for field in slopes}
            carried = _total(slopes[field] * inside(it) for field, it in moved.items() if it is not None)
            parts = dmp, None if ds is None else of_s(ds), None if carried is None else pool(carried)
            return new_maps, _total(parts), df

        found = {name: rows_of(name) for name in names}
        new_maps, mp_row, f_row = ({name: it[i] for name, it in found.items()} for i in range(3))
        return (new, new_maps, (border, *spreads)), ((mp, f), (mp_row, f_row))

    maps = {name: _maps_at_rest(model, name, start, interval) for name in names}
    return jax.lax.scan(step, (start, maps, 3 * (start.on,)), jnp.arange(len(frames)))[1]


def _unit(model, name: str):
    """A tangent of the model: 1 for this parameter, None for all else."""
    nothing = jax.tree.map(lambda _: None, model)
    one = np.ones((), getattr(model.parameters, name).dtype)
    return eqx.tree_at(lambda it: getattr(it.parameters, name), nothing, one, is_leaf=lambda leaf: leaf is None)


def _maps_at_rest(model, name: str, traces: Traces, interval):
    """Sensitivities of a state at rest: 0 for the arrays that this parameter will reach, None for the others."""
    unchanged = traces.on

    def reach(maps):
        def advance(model, traces):
            return remember(model, traces, unchanged, interval)[0]

        return eqx.filter_jvp(advance, (model, traces), (_unit(model, name), maps))[1]

    maps, reached = None, jax.tree.map(lambda _: None, traces)
    while jax.tree.structure(maps) != jax.tree.structure(reached):
        maps = jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), reached)
        reached = eqx.filter_eval_shape(reach, maps)
    return maps


def _total(parts: Iterable[Array | None]) -> Array | None:
    """The sum of what there is; None where there is nothing."""
    present = [part for part in parts if part is not None]
    return functools.reduce(operator.add, present) if present else None
