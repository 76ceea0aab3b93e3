"""What the field calls selectivity, in six numbers, with intervals where a fit knows how sure it is."""

import dataclasses
import math
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Key

from lgmd2jax._characterise import trials
from lgmd2jax._characterise.curves import Curves, curves_of, integral, top
from lgmd2jax._characterise.exam import Exam, sums_of
from lgmd2jax._characterise.measures_looming import LOOMS, law_of_peaks
from lgmd2jax._characterise.measures_selectivity import index
from lgmd2jax._characterise.trials import LIGHT_LOOM, RECESSION, REFERENCE
from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._eye import Eye
from lgmd2jax.fitting import Fit
from lgmd2jax.fitting._uncertainty.covariance import variance_along

UNITS = {
    "approach/recession index": "1",
    "dark/light index": "1",
    "looming/translation ratio": "1",
    "alpha": "1",
    "delta": "ms",
    "threshold angle": "deg",
}
_TRIALS = (*LOOMS, LIGHT_LOOM, RECESSION, trials.translation())
_DRAWS = 100
_CONFIDENCE = 0.95


class Estimate(NamedTuple):
    """A value with its interval at 95 %, NaN where nothing is known of it."""

    value: float
    low: float = math.nan
    high: float = math.nan


def selectivity(curves: Curves) -> dict[str, Float[Array, ""]]:
    """The six numbers of one model.

    Approach/recession and dark/light: (a - b)/(a + b) of the time integrals of R at 40 ms. Looming/translation: ratio
    of the peaks, a disc of 10 degrees at 60 deg/s being what translates; infinite where that leaves the cell at rest.
    alpha, delta: of the line of peak times, from which 2 atan(1/alpha) is the threshold angle.
    """
    dark, light, away = integral(curves(REFERENCE, LIGHT_LOOM, RECESSION))
    alpha, delta = law_of_peaks(curves)
    loom, across = (jnp.maximum(top(curves, name)[0], 0) for name in (REFERENCE, trials.translation()))
    values = (
        index(dark, away),
        index(dark, light),
        loom / across,
        alpha,
        delta,
        2 * jnp.degrees(jnp.arctan2(1, alpha)),
    )
    return dict(zip(UNITS, values, strict=True))


def intervals(fit: Fit, eye: Eye, key: Key[Array, ""], draws: int = _DRAWS) -> dict[str, tuple[float, float]]:
    """The 2.5 and 97.5 percentiles over models drawn from the fit's covariance, thresholds hard as handed over.

    Draws are Gaussian in the unit box of the free parameters and cut at its walls; along a direction that the curves
    leave open they have the variance of a value that may lie anywhere between its bounds. Drawing is right for a
    network with hard thresholds too, where slopes are not.
    """
    u, exam = fit.uncertainty, Exam(eye, only=_TRIALS)
    reach = np.sqrt(variance_along(u))
    steps = np.asarray(jax.random.normal(key, (draws, len(reach)))) * reach
    samples = []
    for z in np.clip(fit.z + steps @ u.directions.T, 0, 1):
        parameters, _ = fit.free.insert(fit.model.parameters, fit.observation, z)
        model = dataclasses.replace(fit.model, parameters=parameters)
        samples.append(jax.device_get(_selectivity(exam, sums_of(exam, model), model)))
    ends = 50 * (1 - _CONFIDENCE), 50 * (1 + _CONFIDENCE)
    return {name: _percentiles(np.array([float(values[name]) for values in samples]), ends) for name in UNITS}


@traced_once
def _selectivity(exam: Exam, sums, model):
    return selectivity(curves_of(exam, sums, model))


def _percentiles(values: np.ndarray, ends: tuple[float, float]) -> tuple[float, float]:
    """Of what is finite, where that is most."""
    finite = values[~np.isnan(values)]
    if len(finite) < _CONFIDENCE * len(values):
        return math.nan, math.nan
    low, high = np.percentile(finite, ends, method="nearest")
    return float(low), float(high)
