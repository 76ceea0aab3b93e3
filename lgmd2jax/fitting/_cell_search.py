"""The search on two levels: for a point of the pixels' parameters, thousands of the cell's on the same sums.

The frame in which the feed-forward gate opens or closes is a discrete event. For a descent it is a local minimum; for a
search over the cell alone it is nothing, because MP(t) and F(t) need not be computed again.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._network.stages import Sums
from lgmd2jax.fitting._problem import Curves, Problem

_AT_ONCE = 256  # candidates side by side: wide enough for vectors, small enough for the cache
_RADIUS = 0.05  # of the second look around the best candidate, in the unit box


class BestCell(NamedTuple):
    """The point with the best cell, its loss, and the loss of the point at which the search began."""

    z: Float[Array, " free"]
    loss: Float[Array, ""]
    loss_before: Float[Array, ""]


@traced_once
def search_cell(
    problem: Problem, z: Float[Array | np.ndarray, " free"], cells: Float[Array | np.ndarray, "count cell"]
) -> BestCell:
    """Search the cell's parameters at the pixels' of `z`, with the model's own thresholds.

    **Arguments:** `cells` in the unit box. The cell of `z` itself is tried too, then the neighbourhood of the best.
    """
    z, place = jnp.asarray(z), jnp.asarray(problem.cell_indices, dtype=int)
    model, _ = problem.at(z)
    sums = problem.sums(model)

    def look(best: BestCell, nearby):
        centre, radius = jnp.where(nearby, best.z[place], 0.5), jnp.where(nearby, _RADIUS, 0.5)
        candidates = jnp.clip(centre[None] + 2 * radius * (jnp.asarray(cells) - 0.5), 0, 1)
        now = _best(problem, sums, best.z, jnp.concatenate([best.z[place][None], candidates]))
        return now._replace(loss_before=jnp.where(nearby, best.loss_before, now.loss_before)), None

    unknown = jnp.full((), jnp.inf, z.dtype)
    return jax.lax.scan(look, BestCell(z, unknown, unknown), jnp.array([False, True]))[0]


def _best(
    problem: Problem, sums: tuple[Sums, ...], z: Float[Array, " free"], cells: Float[Array, "count cell"]
) -> BestCell:
    """The best of the candidates; the loss before is that of the first one as it is given."""
    place = jnp.asarray(problem.cell_indices, dtype=int)

    def one(cell):
        point = z.at[place].set(cell)
        curves = problem.curves(*problem.at(point), sums)
        before = _loss(problem, point, curves)
        point, curves = _with_best_rate(problem, point, curves)
        return point, _loss(problem, point, curves), before

    points, losses, before = jax.lax.map(one, cells, batch_size=min(_AT_ONCE, len(cells)))
    best = jnp.argmin(losses)
    # The best baseline and gain are exact for squares alone; under another loss the first point may be the better one.
    first_is_best = before[0] <= losses[best]
    first = z.at[place].set(cells[0])
    return BestCell(jnp.where(first_is_best, first, points[best]), jnp.minimum(losses[best], before[0]), before[0])


def _loss(problem: Problem, z: Float[Array, " free"], curves: Curves) -> Float[Array, ""]:
    loss = 0.5 * (jnp.square(problem.differences(curves)).sum() + jnp.square(problem.free.penalties(z)).sum())
    return jnp.where(jnp.isnan(loss), jnp.inf, loss)


def _with_best_rate(problem: Problem, z: Float[Array, " free"], curves: Curves) -> tuple[Float[Array, " free"], Curves]:
    """The point and its curves with the best baseline and gain, in which a rate is linear: rate = baseline + gain x.

    Of a band the part that is nearest to the rates counts, so that they come closer to it, if not as close as they can.
    """
    baseline, gain = (problem.free.indices(name) for name in ("baseline", "gain"))
    ties = {tie.to for tie in problem.free.ties.values()} | set(problem.free.ties)
    if not (baseline or gain) or ties & {"baseline", "gain"}:
        return z, curves
    _, observation = problem.at(z)
    b, g = jnp.asarray(observation.baseline), jnp.asarray(observation.gain)
    slots = [slot for batch in problem.batches for slot in batch.slots]
    leaves, tree = jax.tree.flatten(curves)
    shapes = {i: (leaves[i] - b) / g for i, slot in enumerate(slots) if slot.channel == "rate"}

    w = jnp.concatenate([jnp.square(slots[i].scale).ravel() for i in shapes])
    x = jnp.concatenate([shape.ravel() for shape in shapes.values()])
    y = jnp.concatenate([slots[i].nearest(leaves[i]).ravel() for i in shapes])
    s, sx, sy, sxx, sxy = w.sum(), w @ x, w @ y, w @ (x * x), w @ (x * y)
    if baseline and gain:
        g = _within_bounds(problem, gain[0], (s * sxy - sx * sy) / jnp.maximum(s * sxx - sx * sx, 1e-12))
    if baseline:
        b = _within_bounds(problem, baseline[0], (sy - g * sx) / s)
        z = z.at[baseline[0]].set(problem.free.parameters[baseline[0]].place(b))
    if gain:
        g = _within_bounds(problem, gain[0], (sxy - b * sx) / jnp.maximum(sxx, 1e-12))
        z = z.at[gain[0]].set(problem.free.parameters[gain[0]].place(g))
    leaves = [b + g * shapes[i] if i in shapes else leaf for i, leaf in enumerate(leaves)]
    return z, jax.tree.unflatten(tree, leaves)


def _within_bounds(problem: Problem, index: int, value: Float[Array, ""]) -> Float[Array, ""]:
    parameter = problem.free.parameters[index]
    return jnp.clip(value, parameter.low, parameter.high)
