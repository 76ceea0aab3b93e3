"""Which fixed parameter, freed, would lower chi2 most: a score test from the slopes at the best fit."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import jax
import numpy as np
import scipy
from jaxtyping import Bool, Float

from lgmd2jax._types import Scalar
from lgmd2jax.fitting._bounds import Linear
from lgmd2jax.fitting._problem import Problem
from lgmd2jax.fitting._uncertainty.covariance import Uncertainty
from lgmd2jax.fitting._uncertainty.jacobian import known_rows, sensitivity_at


class Score(NamedTuple):
    """What freeing a fixed parameter promises, to first order in the curves.

    - `value`: at which it is fixed. `better`: where chi2 would be least, within its declared bounds, in its own unit.
    - `decrease`: of chi2 there, the free parameters following.
    - `probability`: of so large a decrease by chance, were the fixed value true (chi2 with one degree of freedom).
    """

    name: str
    value: float
    better: float
    decrease: float
    probability: float


def score_test(
    problem: Problem,
    z: Float[np.ndarray, " free"],
    temperature: Scalar,
    u: Uncertainty,
    fixed: Mapping[str, Linear],
    values: Float[np.ndarray, " candidate"],
) -> list[Score]:
    """The fixed parameters of a problem, the one that promises most first.

    **Arguments:** `z`: the best fit, with its uncertainty `u`. `fixed`: by name the bounds of each. `values`: at which
    they are fixed.
    """
    bounds = np.array([(choice.low, choice.high) for choice in fixed.values()])
    wider = dataclasses.replace(problem, free=problem.free.also(**fixed).of(type(problem.model.parameters)))
    place = np.append(z, (values - bounds[:, 0]) / np.ptp(bounds, axis=1))
    jacobian, residuals = known_rows(wider, sensitivity_at(wider, jax.device_put(place), temperature))
    scale = np.ones(len(residuals))
    scale[: len(residuals) - problem.priors] = np.sqrt(u.variance or 1.0)
    jacobian, residuals, count = jacobian / scale[:, None], residuals / scale, len(z)
    return promises(
        residuals,
        jacobian[:, :count],
        jacobian[:, count:] / np.ptp(bounds, axis=1),
        names=tuple(fixed),
        values=values,
        bounds=bounds,
        held=u.on_bound != 0,
    )


def promises(
    residuals: Float[np.ndarray, " n"],
    jacobian: Float[np.ndarray, "n free"],
    candidates: Float[np.ndarray, "n candidate"],
    *,
    names: Sequence[str],
    values: Float[np.ndarray, " candidate"],
    bounds: Float[np.ndarray, "candidate 2"],
    held: Bool[np.ndarray, " free"],
) -> list[Score]:
    """The candidates, the one that promises most first (Rao, 1948).

    Chi2 near the fit is |r + J d + g s|^2. Over the free d its least value falls with s by b s - a s^2 / 2, where g is
    taken at right angles to J; the step is cut at the bounds.

    **Arguments:** `residuals`, and their slopes by what is free and by each candidate, in standard errors; `values` and
    `bounds` of the candidates in their own unit, `candidates` by these; `held`: free parameters that a bound holds.
    """
    directions, singular, _ = np.linalg.svd(jacobian[:, ~held], full_matrices=False)
    directions = directions[:, singular > 1e-10 * singular.max(initial=0.0)]
    alone = candidates - directions @ (directions.T @ candidates)
    rest = residuals - directions @ (directions.T @ residuals)
    scores = []
    for name, value, (low, high), slope, whole in zip(names, values, bounds, alone.T, candidates.T, strict=True):
        curvature, fall = float(slope @ slope), -float(slope @ rest)
        if curvature <= 1e-12 * float(whole @ whole):  # the free ones can replace it, or it changes nothing
            continue
        value = float(value)
        better = float(np.clip(value + fall / curvature, low, high))
        step = better - value
        decrease = 2 * fall * step - curvature * step**2
        scores.append(Score(name, value, better, decrease, float(scipy.stats.chi2.sf(decrease, 1))))
    return sorted(scores, key=lambda score: -score.decrease)
