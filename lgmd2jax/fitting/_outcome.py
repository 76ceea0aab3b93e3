"""From the best point of a search to a fit: the model, its curves, and how well it is determined."""

import dataclasses
from collections import Counter
from collections.abc import Sequence
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._network.thresholds import Hard
from lgmd2jax._targets.target import Target
from lgmd2jax.fitting._curve import Curve, curve_of
from lgmd2jax.fitting._descent import Run
from lgmd2jax.fitting._problem import Problem, weighed
from lgmd2jax.fitting._result import Fit
from lgmd2jax.fitting._uncertainty.covariance import Uncertainty, prediction_band, uncertainty
from lgmd2jax.fitting._uncertainty.jacobian import Sensitivity, sensitivity
from lgmd2jax.fitting._uncertainty.linearity import curved
from lgmd2jax.stimuli import Stimulus

Pairs = Sequence[tuple[Stimulus, Sequence[Target]]]


def outcome(
    problem: Problem,
    pairs: Pairs,
    *,
    runs: tuple[Run, ...],
    screened: tuple[float, ...],
    start: Float[np.ndarray, " free"],
    temperatures: tuple[float, ...],
    absolute_errors: bool | None,
    result: str,
    stats: dict[str, Any],
) -> Fit:
    """The fit whose best run is the first one. Errors and intervals are those of the last temperature."""
    z, free, data = np.array(runs[0].z), problem.free, int(problem.known().sum()) - problem.priors
    model, observation = problem.at(z)
    seen = sensitivity(problem, jnp.asarray(z), jnp.asarray(temperatures[-1], dtype=float))
    if absolute_errors is None:
        absolute_errors = all(target.has_error for _, targets in pairs for target in targets)
    u = _uncertainty(problem, z, seen, absolute_errors)
    return Fit(
        model=model,
        observation=observation,
        free=free,
        z=z,
        start={it.name: float(it.value(place)) for it, place in zip(free.freedoms, start, strict=True)},
        loss=runs[0].loss,
        soft_loss=0.5 * float(jnp.square(seen.residuals).sum()),
        temperatures=temperatures,
        uncertainty=u,
        curved=curved(weighed(problem, temperatures[-1], u.variance), z, u),
        curves=tuple(_curves(problem, pairs, seen, _hard_curves(problem, jnp.asarray(z)), u)),
        runs=runs,
        screened=screened,
        errors=_errors(problem, u.variance),
        result=result,
        stats=stats | {"data": data, "num_steps": sum(run.steps for run in runs), "rules": _rules(pairs)},
        problem=problem,
    )


def _rules(pairs: Pairs) -> dict[str, int]:
    """How samples are counted and errors arose, where that is not plain, and of how many targets."""
    return dict(Counter(rule for _, targets in pairs for target in targets for rule in target.rules))


def _uncertainty(problem: Problem, z: np.ndarray, seen: Sensitivity, absolute: bool) -> Uncertainty:
    free, rows = problem.free, problem.known()
    return uncertainty(
        free.names,
        z,
        free.unpacked,
        free.slopes(z),
        np.asarray(seen.jacobian)[rows],
        np.asarray(seen.residuals)[rows],
        n_effective=problem.samples(),
        absolute=absolute,
        priors=problem.priors,
    )


@eqx.filter_jit
def _hard_curves(problem: Problem, z: Float[Array, " free"]):
    model, observation = problem.at(z)
    hard = dataclasses.replace(model, thresholds=Hard())
    return problem.curves(hard, observation, problem.potentials(hard))


def _curves(problem: Problem, pairs: Pairs, seen: Sensitivity, hard, u: Uncertainty) -> list[Curve]:
    """A curve for every target, in the order of the conditions."""
    curves = []
    for (stimulus, targets), places in zip(pairs, problem.places, strict=True):
        for target, (batch, slot, row) in zip(targets, places, strict=True):
            length = len(target.values)
            soft, handed, slopes = (
                np.asarray(it[batch][slot][row])[:length] for it in (seen.curves, hard, seen.slopes)
            )
            curves.append(curve_of(stimulus, target, soft, handed, prediction_band(u, slopes)))
    return curves


def _errors(problem: Problem, variance: float) -> dict[str, float]:
    """By channel, the error of a frame whose neighbours tell nothing of it: correlated ones count as a fraction."""
    rows: dict[str, list[np.ndarray]] = {}
    for batch in problem.batches:
        for slot in batch.slots:
            scale = np.asarray(slot.scale) / np.sqrt(np.asarray(slot.thinning))[:, None]
            rows.setdefault(slot.channel, []).append(scale[scale > 0])
    noise = max(float(np.sqrt(variance)), 1e-9)  # a twin without noise has none
    return {channel: noise / float(np.median(np.concatenate(scales))) for channel, scales in rows.items()}
