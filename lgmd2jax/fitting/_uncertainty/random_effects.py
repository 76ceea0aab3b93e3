"""A parameter over animals: its mean and its spread, beyond what the errors of the single fits explain."""

from typing import NamedTuple

import numpy as np
import scipy
from jaxtyping import Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax.fitting._uncertainty.covariance import CONFIDENCE


class RandomEffects(NamedTuple):
    """Mean of a population with its standard error and 95 % interval, and the population's standard deviation.

    - `inconsistency`: I2, the share of the variance between estimates that is not their own error's.
    """

    mean: float
    standard_error: float
    interval: tuple[float, float]
    spread: float
    inconsistency: float


@checked
def random_effects(
    estimates: Float[np.ndarray, " animal"], standard_errors: Float[np.ndarray, " animal"]
) -> RandomEffects:
    """Estimates y_i of effects from N(mean, spread^2), each with an error s_i: y_i ~ N(mean, spread^2 + s_i^2).

    The spread maximises the restricted likelihood (REML). The interval of the mean is that of Hartung and Knapp, by
    Student's t, never narrower than the errors say, for few animals.

    **Raises:** `ValueError` for fewer than two estimates, and for errors that are not positive.

    Source: Viechtbauer 2005; Röver, Knapp & Friede 2015.
    """
    y, v = np.asarray(estimates, float), np.square(np.asarray(standard_errors, float))
    if len(y) < 2 or not (np.isfinite(v) & (v > 0)).all():
        raise ValueError(f"estimates are {y} with errors {np.sqrt(v)}; give two or more, with errors that are positive")

    def weighted(tau: float) -> tuple[Float[np.ndarray, " animal"], float]:
        weights = 1 / (v + tau**2)
        return weights, float(weights @ y / weights.sum())

    def minus_two_log_likelihood(tau: float) -> float:
        weights, mean = weighted(tau)
        return float(weights @ np.square(y - mean) - np.log(weights).sum() + np.log(weights.sum()))

    widest = 10 * (np.ptp(y) + np.sqrt(v.max()))
    solution = scipy.optimize.minimize_scalar(
        minus_two_log_likelihood, bounds=(0, widest), method="bounded", options={"xatol": 1e-9 * widest}
    )
    spread = float(solution.x) if solution.x > 1e-6 * widest else 0.0  # the search stays within its bounds
    weights, mean = weighted(spread)
    degrees = len(y) - 1
    scatter = weights @ np.square(y - mean) / degrees  # 1 as a rule; less of it is chance
    error = float(np.sqrt(max(scatter, 1.0) / weights.sum()))
    reach = float(scipy.stats.t.ppf(0.5 + CONFIDENCE / 2, degrees)) * error
    alone, fixed = weighted(0.0)
    excess = 1 - degrees / max(float(alone @ np.square(y - fixed)), np.finfo(float).tiny)
    return RandomEffects(mean, error, (mean - reach, mean + reach), spread, max(excess, 0.0))
