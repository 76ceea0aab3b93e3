"""One target, a curve or a band, beside the fitted model's response."""

import dataclasses
from collections.abc import Sequence
from typing import Literal, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._channels import TARGETS, Channel
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._targets.observation import Observation
from lgmd2jax._targets.target import Target
from lgmd2jax._words import warn_renamed
from lgmd2jax.fitting._poisson import LEAST_RATE, bin_means, deviance_residuals, minus_two_log_likelihood
from lgmd2jax.stimuli import Stimulus

Kind = Literal["soft", "hard", "silence"]
Grade = Literal["good", "fair", "missed"]
DISAGREEMENT = 0.05  # of the span, from which soft and hard are said to differ
_GOOD, _FAIR = 0.9, 0.5  # least R2
_HALF = 0.5  # of silence's RMSE, that a response may miss by at most
_QUIET, _GOOD_QUIET, _FAIR_QUIET = 0.01, 0.03, 0.1  # of the span
_GOOD_BAND, _FAIR_BAND = 0.9, 0.7  # least share of samples within a band
# The rules, in sentences.
GRADES = (
    f"Good: R2 of the hard model at least {_GOOD:g}; fair: at least {_FAIR:g}; both only where its RMSE is at most "
    f"{_HALF:g} of that of silence, a model that stays at rest. Of a constant target away from rest the variance is "
    "that about rest.",
    f"Where silence itself misses by less than {_QUIET:.0%} of the span, quiet is asked: good is then an RMSE of at "
    f"most {_GOOD_QUIET:.0%} of the span, fair one of at most {_FAIR_QUIET:.0%}. The span is the target's range, but "
    "no less than half of what the channel can do.",
    "Missed: all else.",
)
OF_COUNTS = "Of counts of spikes R2 is the share of the deviance that is explained; chance alone leaves about 1 a bin."
BAND_GRADES = (
    f"Good: at least {_GOOD_BAND:.0%} of the hard model's samples within; fair: at least {_FAIR_BAND:.0%}; both only "
    f"where silence, a model that stays at rest, has fewer within, or itself {_GOOD_BAND:.0%}. Missed: all else.",
)


@dataclasses.dataclass(frozen=True)
class Curve:
    """A target, the soft model at the last temperature, and the hard one, at the frames of a condition.

    - `time`: ms. `target`, `sem`, `soft`, `hard`: in the unit of the channel; `sem` is NaN where none was recorded.
    - `weight`: of the squared difference; 0 where there is no target.
    - `band`: standard error of the prediction, from that of the parameters.
    - `rest`: the channel of a cell that stays at rest, in its unit.
    - `error`: standard error with which a frame counts in chi2, the larger the more frames make one independent sample;
      NaN where there is no target, and throughout where an earlier version wrote the curves.
    - `upper`: makes the target a band, of which `target` is the lower edge. `quote`: the words that it stands for.
    - `exposure`: makes the target counts of spikes by this time, in s; NaN where there is no target. Chi2 is then the
      deviance, and R2 the share of it that the model explains.
    """

    condition: str
    channel: Channel
    time: Float[np.ndarray, " time"]
    target: Float[np.ndarray, " time"]
    sem: Float[np.ndarray, " time"]
    weight: Float[np.ndarray, " time"]
    soft: Float[np.ndarray, " time"]
    hard: Float[np.ndarray, " time"]
    band: Float[np.ndarray, " time"]
    rest: float
    error: Float[np.ndarray, " time"]
    upper: Float[np.ndarray, " time"] | None = None
    quote: str = ""
    exposure: Float[np.ndarray, " time"] | None = None

    @property
    def silence(self) -> Float[np.ndarray, " time"]:
        """A model that stays at rest throughout."""
        return np.full(self.target.shape, self.rest)

    @checked
    def r2(self, kind: Kind = "hard") -> float:
        """Share of the target's variance that the model explains; NaN for a band, and for one that does not vary."""
        if self.is_band:
            return float("nan")
        if self.exposure is not None:
            return 1 - self.chi2(kind) / self.chi2_of_mean
        return variance_explained(self.target, getattr(self, kind), self.weight)

    @checked
    def rmse(self, kind: Kind = "hard") -> float:
        """Root of the mean squared difference from the target, in the channel's unit."""
        return float(np.sqrt(np.average(self.distance(kind) ** 2, weights=self.weight)))

    @property
    def is_band(self) -> bool:
        """Whether the target is a band."""
        return self.upper is not None

    @property
    def high(self) -> Float[np.ndarray, " time"]:
        """The upper edge of a band; of a curve the target itself."""
        return self.target if self.upper is None else self.upper

    @checked
    def distance(self, kind: Kind = "hard") -> Float[np.ndarray, " time"]:
        """The distance from the target at each frame, in the channel's unit, negative below it; 0 within a band."""
        response = getattr(self, kind)
        return response - np.clip(response, self.target, self.high)

    @checked
    def inside(self, kind: Kind = "hard") -> float:
        """Share of the samples that count which lie within the band."""
        return float(np.mean(self.distance(kind)[self.weight > 0] == 0))

    @checked
    def chi2(self, kind: Kind = "hard") -> float:
        """Sum of the squared distances in standard errors, of independent samples; NaN where errors are unknown."""
        if self.exposure is not None:
            return float(np.square(self.deviance_residuals(getattr(self, kind))).sum())
        return self._chi2_of(self.distance(kind))

    @checked
    def deviance_residuals(self, rate: Float[np.ndarray, " time"]) -> Float[np.ndarray, " counted"]:
        """The deviance residuals of counts of spikes, where they count, from a rate in spikes/s."""
        counts, means = self._counts_and_means(rate)
        return np.asarray(deviance_residuals(jnp.asarray(counts), jnp.asarray(means)))

    @checked
    def minus_two_log_likelihood(self, kind: Kind = "hard") -> float:
        """-2 ln L of counts of spikes under the model, all terms included."""
        return minus_two_log_likelihood(*self._counts_and_means(getattr(self, kind)))

    def _counts_and_means(
        self, rate: Float[np.ndarray, " time"]
    ) -> tuple[Float[np.ndarray, " counted"], Float[np.ndarray, " counted"]]:
        counted, exposure = self.weight > 0, self.exposure
        if exposure is None:
            raise ValueError(f"the target of {self.condition!r} is not a count of spikes; give it an exposure")
        means = np.maximum(bin_means(jnp.asarray(rate), jnp.asarray(counted)), LEAST_RATE)
        return self.target[counted] * exposure[counted], means[counted] * exposure[counted]

    @property
    def chi2_of_mean(self) -> float:
        """Chi2 of a constant, the target's own mean: what there is to explain; NaN for a band."""
        if self.exposure is not None:
            counted = self.weight > 0
            mean = np.average(self.target[counted], weights=self.exposure[counted])
            return float(np.square(self.deviance_residuals(np.full(self.target.shape, mean))).sum())
        return (
            float("nan") if self.is_band else self._chi2_of(self.target - np.average(self.target, weights=self.weight))
        )

    def _chi2_of(self, distance: Float[np.ndarray, " time"]) -> float:
        counted = self.weight > 0
        return float(np.square(distance[counted] / self.error[counted]).sum())

    @property
    def span(self) -> float:
        """What counts as a large response: the target's range, but no less than half of what the channel can do."""
        edges = np.concatenate([self.target[self.weight > 0], self.high[self.weight > 0]])
        return max(float(np.ptp(edges[np.isfinite(edges)])), (TARGETS[self.channel].span or 2e-12) / 2)

    @property
    def gap(self) -> float:
        """Root of the mean squared difference of soft and hard, as a share of `span`."""
        return float(np.sqrt(np.average((self.soft - self.hard) ** 2, weights=self.weight))) / self.span

    @property
    def grade(self) -> Grade:
        """How well the hard model meets the target, by the rules that `GRADES` and `BAND_GRADES` state."""
        return self._band_grade if self.is_band else self._curve_grade

    @property
    def _band_grade(self) -> Grade:
        share, silence = self.inside(), self.inside("silence")
        if silence < _GOOD_BAND and share <= silence:
            return "missed"
        return "good" if share >= _GOOD_BAND else "fair" if share >= _FAIR_BAND else "missed"

    @property
    def _curve_grade(self) -> Grade:
        if self.exposure is not None:
            return self._counts_grade
        miss, silence = self.rmse(), self.rmse("silence")
        if silence < _QUIET * self.span:
            return (
                "good" if miss <= _GOOD_QUIET * self.span else "fair" if miss <= _FAIR_QUIET * self.span else "missed"
            )
        if miss > _HALF * silence:
            return "missed"
        r2 = 1 - (miss / silence) ** 2 if np.isnan(self.r2()) else self.r2()
        return "good" if r2 >= _GOOD else "fair" if r2 >= _FAIR else "missed"

    @property
    def _counts_grade(self) -> Grade:
        """By the share of the deviance that can be explained: chance alone leaves about 1 a bin."""
        bins = np.count_nonzero(self.weight > 0)
        left, whole = max(self.chi2() - bins, 0.0), self.chi2_of_mean - bins
        r2 = 1 - left / max(whole, bins**0.5)
        return "good" if r2 >= _GOOD else "fair" if r2 >= _FAIR else "missed"

    @property
    def met(self) -> bool:
        """The old name of a `grade` other than missed."""
        warn_renamed("Curve.met", "Curve.grade")
        return self.grade != "missed"


class Tally(NamedTuple):
    """The bands that stand for the same words.

    - `samples`: of them that count. `soft`, `hard`: share of these within. `farthest`: of the hard model from a band,
      as a distance.
    """

    quote: str
    samples: int
    soft: float
    hard: float
    farthest: float


def tallies(curves: Sequence[Curve]) -> list[Tally]:
    """The bands by their words, in the order in which these come first; those without words are left out."""
    quotes = dict.fromkeys(curve.quote for curve in curves if curve.is_band and curve.quote)
    return [_tally(quote, [curve for curve in curves if curve.quote == quote]) for quote in quotes]


def _tally(quote: str, curves: Sequence[Curve]) -> Tally:
    soft, hard = (
        np.concatenate([curve.distance(kind)[curve.weight > 0] for curve in curves]) for kind in ("soft", "hard")
    )
    return Tally(quote, len(hard), float(np.mean(soft == 0)), float(np.mean(hard == 0)), float(np.abs(hard).max()))


def predict(
    model: AbstractNetwork, observation: Observation, stimulus: Stimulus, channel: Channel
) -> Float[np.ndarray, " time"]:
    """A channel of the response to a stimulus; `"rate"` by the observation."""
    response = model(stimulus.frames, stimulus.fps)
    if channel == "rate":
        return np.asarray(observation(response.smp_adapted, jnp.asarray(stimulus.time)))
    return np.asarray(getattr(response, channel))


def variance_explained(target: np.ndarray, curve: np.ndarray, weight: np.ndarray) -> float:
    """R2 = 1 - (mean squared difference)/(variance of the target), weighted; NaN for a target that does not vary."""
    variance = np.average((target - np.average(target, weights=weight)) ** 2, weights=weight)
    if variance < 1e-12 * max(1.0, np.abs(target).max()) ** 2:
        return float("nan")
    return float(1 - np.average((curve - target) ** 2, weights=weight) / variance)


def rest_of(channel: Channel, observation: Observation) -> float:
    """A channel of a cell at rest, in its unit."""
    rest = TARGETS[channel].rest
    return float(observation.baseline) if rest is None else rest


def curve_of(
    stimulus: Stimulus, target: Target, soft: np.ndarray, hard: np.ndarray, band: np.ndarray, rest: float
) -> Curve:
    """The curves of one target, whose values stand at the frames of its stimulus."""
    nothing = np.full(len(target.values), np.nan)
    sem = nothing if target.sem is None else np.asarray(target.sem)
    weight = np.broadcast_to(target.weight, target.values.shape)
    time, scale = np.asarray(stimulus.time), target.scale
    error = np.where(scale > 0, np.sqrt(target.thinning) / np.where(scale > 0, scale, 1), np.nan)
    return Curve(
        stimulus.name,
        target.channel,
        time,
        target.values,
        sem,
        weight,
        soft,
        hard,
        band,
        rest,
        error,
        upper=target.upper,
        quote=target.quote,
        exposure=target.exposure,
    )
