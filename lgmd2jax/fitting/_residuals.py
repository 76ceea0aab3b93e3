"""What a fit leaves unexplained: the residuals of a curve, and over how long neighbouring ones are alike."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from lgmd2jax.fitting._curve import Curve, Kind


class Residuals(NamedTuple):
    """Response less target where the target counts, in the unit of the channel, with the times in ms.

    Of counts of spikes they are deviance residuals, in standard errors.
    """

    time: Float[np.ndarray, " sample"]
    values: Float[np.ndarray, " sample"]

    @property
    def autocorrelation(self) -> Float[np.ndarray, " sample"]:
        """By lag in samples, 1 at lag 0; NaN where the residuals do not vary."""
        about_mean = self.values - self.values.mean()
        count = len(about_mean)
        if about_mean @ about_mean == 0:
            return np.full(count, np.nan)
        spectrum = np.fft.rfft(about_mean, 2 * count)  # as many zeros follow, lest the end meet the beginning
        covariance = np.fft.irfft(np.abs(spectrum) ** 2, 2 * count)[:count]
        return covariance / covariance[0]

    @property
    def interval(self) -> float:
        """From one sample to the next, in ms, as a rule: the median."""
        return float(np.median(np.diff(self.time))) if len(self.time) > 1 else 0.0

    @property
    def correlation_ms(self) -> float:
        """The span that makes one independent residual: the integral of the autocorrelation up to its first zero."""
        positive = self.autocorrelation
        ends = np.flatnonzero(~(positive > 0))
        return self.interval * float(2 * positive[: ends[0] if ends.size else None].sum() - 1) if positive[0] else 0.0


def residuals_of(curve: Curve, kind: Kind = "hard") -> Residuals:
    """The residuals of a curve; within a band they are 0."""
    counted = curve.weight > 0
    if curve.exposure is not None:
        return Residuals(curve.time[counted], curve.deviance_residuals(getattr(curve, kind)))
    return Residuals(curve.time[counted], curve.distance(kind)[counted])
