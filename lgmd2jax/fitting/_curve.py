"""One target beside the fitted model's response."""

import dataclasses
from typing import Literal

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from lgmd2jax._channels import TARGETS, Channel
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._targets.observation import Observation
from lgmd2jax._targets.target import Target
from lgmd2jax.stimuli import Stimulus

Kind = Literal["soft", "hard"]
DISAGREEMENT = 0.05  # of the span, from which soft and hard are said to differ


@dataclasses.dataclass(frozen=True)
class Curve:
    """A target, the soft model at the last temperature, and the hard one, at the frames of a condition.

    - `time`: ms. `target`, `sem`, `soft`, `hard`: in the unit of the channel; `sem` is NaN where none was recorded.
    - `weight`: of the squared difference; 0 where there is no target.
    - `band`: standard error of the prediction, from that of the parameters.
    - `error`: standard error with which a frame counts in chi2, the larger the more frames make one independent sample;
      NaN where there is no target, and throughout where an earlier version wrote the curves.
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
    error: Float[np.ndarray, " time"]

    def r2(self, kind: Kind = "hard") -> float:
        """Share of the target's variance that the model explains; NaN for a target that does not vary."""
        return variance_explained(self.target, getattr(self, kind), self.weight)

    def rmse(self, kind: Kind = "hard") -> float:
        """Root of the mean squared difference from the target, in the channel's unit."""
        return float(np.sqrt(np.average((getattr(self, kind) - self.target) ** 2, weights=self.weight)))

    def chi2(self, kind: Kind = "hard") -> float:
        """Sum of the squared differences in standard errors, of independent samples; NaN where errors are unknown."""
        return self._chi2_of(getattr(self, kind))

    @property
    def chi2_of_mean(self) -> float:
        """Chi2 of a constant, the target's own mean: what there is to explain."""
        return self._chi2_of(np.average(self.target, weights=self.weight))

    def _chi2_of(self, values: np.ndarray | np.floating) -> float:
        return float(np.square((values - self.target) / self.error)[self.weight > 0].sum())

    @property
    def span(self) -> float:
        """What counts as a large response: the target's range, but no less than half of what the channel can do."""
        return max(float(np.ptp(self.target[self.weight > 0])), (TARGETS[self.channel].span or 2e-12) / 2)

    @property
    def gap(self) -> float:
        """Root of the mean squared difference of soft and hard, as a share of `span`."""
        return float(np.sqrt(np.average((self.soft - self.hard) ** 2, weights=self.weight))) / self.span

    @property
    def met(self) -> bool:
        """Whether the hard model comes close: it explains half of the variance, or misses by a tenth of `span`."""
        return self.r2() >= 0.5 or self.rmse() <= 0.1 * self.span


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


def curve_of(stimulus: Stimulus, target: Target, soft: np.ndarray, hard: np.ndarray, band: np.ndarray) -> Curve:
    """The curves of one target, whose values stand at the frames of its stimulus."""
    nothing = np.full(len(target.values), np.nan)
    sem = nothing if target.sem is None else np.asarray(target.sem)
    weight = np.broadcast_to(target.weight, target.values.shape)
    time, scale = np.asarray(stimulus.time), target.scale
    error = np.where(scale > 0, np.sqrt(target.thinning) / np.where(scale > 0, scale, 1), np.nan)
    return Curve(stimulus.name, target.channel, time, target.values, sem, weight, soft, hard, band, error)
