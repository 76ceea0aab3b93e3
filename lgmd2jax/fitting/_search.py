"""The search on two levels: for a point of the pixels' parameters, thousands of the cell's on the same potentials.

The frame in which the feed-forward gate opens or closes is a discrete event. For a descent it is a local minimum; for a
search over the cell alone it is nothing, because MP(t) and F(t) need not be computed again.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import scipy
from jaxtyping import Array, Float

from lgmd2jax.fitting._problem import Potentials, Problem
from lgmd2jax.fitting._space import Space

_AT_ONCE = 256  # candidates side by side: wide enough for vectors, small enough for the cache
_RADIUS = 0.05  # of the second look around the best candidate, in the unit box


class Found(NamedTuple):
    """The best point seen, its loss, and the loss of the point that was asked about."""

    z: Float[Array, " free"]
    loss: Float[Array, ""]
    loss_before: Float[Array, ""]


def sobol(dimensions: int, count: int, seed: tuple[int, ...]) -> Float[np.ndarray, "count dimensions"]:
    """Points that fill the unit box evenly; another seed, other points."""
    if dimensions == 0:
        return np.zeros((1, 0))
    sampler = scipy.stats.qmc.Sobol(dimensions, scramble=True, rng=np.random.default_rng(list(seed)))
    return sampler.random_base2(max(count - 1, 1).bit_length())[:count]


def words_of(key: Array) -> tuple[int, ...]:
    """A key as the whole numbers that seed what NumPy and SciPy draw."""
    return tuple(int(word) for word in np.ravel(jax.random.key_data(key)))


def starting_points(
    space: Space, start: Float[np.ndarray, " free"], count: int, seed: tuple[int, ...]
) -> Float[np.ndarray, "count free"]:
    """The start, then points that differ from it in what the pixels need."""
    points = np.repeat(start[None], count, axis=0)
    pixels = list(space.pixel_indices)
    if pixels:
        points[1:, pixels] = sobol(len(pixels), count, seed)[: count - 1]
    return points


@eqx.filter_jit
def search_cell(
    problem: Problem, z: Float[Array | np.ndarray, " free"], cells: Float[Array | np.ndarray, "count cell"]
) -> Found:
    """Search the cell's parameters at the pixels' of `z`, with the model's own thresholds.

    **Arguments:** `cells` in the unit box. The cell of `z` itself is tried too, then the neighbourhood of the best.
    """
    z, place = jnp.asarray(z), jnp.asarray(problem.cell_indices, dtype=int)
    model, _ = problem.at(z)
    seen = problem.potentials(model)

    def look(best: Found, around):
        centre, radius = jnp.where(around, best.z[place], 0.5), jnp.where(around, _RADIUS, 0.5)
        tried = jnp.clip(centre[None] + 2 * radius * (jnp.asarray(cells) - 0.5), 0, 1)
        now = _best(problem, seen, best.z, jnp.concatenate([best.z[place][None], tried]))
        return now._replace(loss_before=jnp.where(around, best.loss_before, now.loss_before)), None

    unknown = jnp.full((), jnp.inf, z.dtype)
    return jax.lax.scan(look, Found(z, unknown, unknown), jnp.array([False, True]))[0]


def _best(problem: Problem, seen: Potentials, z: Float[Array, " free"], cells: Float[Array, "count cell"]) -> Found:
    """The best of the candidates; the loss before is that of the first one as it is given."""

    def one(cell):
        point = z.at[jnp.asarray(problem.cell_indices, dtype=int)].set(cell)
        curves = problem.curves(*problem.at(point), seen)
        before = _loss(problem, point, curves)
        point, curves = _best_rate(problem, point, curves)
        return point, _loss(problem, point, curves), before

    points, losses, before = jax.lax.map(one, cells, batch_size=min(_AT_ONCE, len(cells)))
    place = jnp.argmin(losses)
    # Solving for the rate's scale is exact for squares alone; elsewhere the point as it was may be the better one.
    kept = before[0] <= losses[place]
    own = z.at[jnp.asarray(problem.cell_indices, dtype=int)].set(cells[0])
    return Found(jnp.where(kept, own, points[place]), jnp.minimum(losses[place], before[0]), before[0])


def _loss(problem: Problem, z, curves):
    loss = 0.5 * (jnp.square(problem.differences(curves)).sum() + jnp.square(problem.free.penalties(z)).sum())
    return jnp.where(jnp.isnan(loss), jnp.inf, loss)


def _best_rate(problem: Problem, z, curves):
    """The point and its curves with the best baseline and gain, which a rate is linear in."""
    baseline, gain = (problem.free.indices(name) for name in ("baseline", "gain"))
    tied = {tie.to for tie in problem.free.ties.values()} | set(problem.free.ties)
    if not (baseline or gain) or tied & {"baseline", "gain"}:
        return z, curves
    _, observation = problem.at(z)
    b, g = jnp.asarray(observation.baseline), jnp.asarray(observation.gain)
    rates = [
        (slot, (curve - b) / g)
        for batch, predicted in zip(problem.batches, curves, strict=True)
        for slot, curve in zip(batch.slots, predicted, strict=True)
        if slot.channel == "rate"
    ]
    w, x, y = (
        jnp.concatenate([jnp.ravel(pick(slot, curve)) for slot, curve in rates])
        for pick in (lambda s, _: jnp.square(s.scale), lambda _, c: c, lambda s, _: s.values)
    )
    s, sx, sy, sxx, sxy = w.sum(), w @ x, w @ y, w @ (x * x), w @ (x * y)
    if baseline and gain:
        g = _within(problem, gain, (s * sxy - sx * sy) / jnp.maximum(s * sxx - sx * sx, 1e-12))
    if baseline:
        b = _within(problem, baseline, (sy - g * sx) / s)
    if gain:
        g = _within(problem, gain, (sxy - b * sx) / jnp.maximum(sxx, 1e-12))
    for index, value in ((baseline, b), (gain, g)):
        if index:
            z = z.at[index[0]].set(problem.free.freedoms[index[0]].place(value))
    solved = iter([b + g * x for _, x in rates])
    curves = [
        [next(solved) if slot.channel == "rate" else curve for slot, curve in zip(batch.slots, predicted, strict=True)]
        for batch, predicted in zip(problem.batches, curves, strict=True)
    ]
    return z, curves


def _within(problem: Problem, index: tuple[int, ...], value):
    freedom = problem.free.freedoms[index[0]]
    return jnp.clip(value, freedom.low, freedom.high)
