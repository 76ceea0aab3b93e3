"""One target, a curve or a band, beside the fitted model's response."""

import dataclasses
from collections.abc import Sequence
from typing import Literal, NamedTuple

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
_MOST = 0.9  # share of samples within a band, from which it counts as met


@dataclasses.dataclass(frozen=True)
class Curve:
    """A target, the soft model at the last temperature, and the hard one, at the frames of a condition.

    - `time`: ms. `target`, `sem`, `soft`, `hard`: in the unit of the channel; `sem` is NaN where none was recorded.
    - `weight`: of the squared difference; 0 where there is no target.
    - `band`: standard error of the prediction, from that of the parameters.
    - `upper`: makes the target a band, of which `target` is the lower edge. `quote`: the words that it stands for.
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
    upper: Float[np.ndarray, " time"] | None = None
    quote: str = ""

    def r2(self, kind: Kind = "hard") -> float:
        """Share of the target's variance that the model explains; NaN for a band, and for one that does not vary."""
        if self.is_band:
            return float("nan")
        return variance_explained(self.target, getattr(self, kind), self.weight)

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

    def distance(self, kind: Kind = "hard") -> Float[np.ndarray, " time"]:
        """From the target, in the channel's unit, negative below; 0 within a band."""
        response = getattr(self, kind)
        return response - np.clip(response, self.target, self.high)

    def inside(self, kind: Kind = "hard") -> float:
        """Share of the samples that count which lie within the band."""
        return float(np.mean(self.distance(kind)[self.weight > 0] == 0))

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
    def met(self) -> bool:
        """Whether the hard model comes close: it explains half of the variance, or misses by a tenth of `span`.

        Of a band nine tenths of the samples must lie within.
        """
        if self.is_band:
            return self.inside() >= _MOST
        return self.r2() >= 0.5 or self.rmse() <= 0.1 * self.span


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


def curve_of(stimulus: Stimulus, target: Target, soft: np.ndarray, hard: np.ndarray, band: np.ndarray) -> Curve:
    """The curves of one target, whose values stand at the frames of its stimulus."""
    nothing = np.full(len(target.values), np.nan)
    sem = nothing if target.sem is None else np.asarray(target.sem)
    weight = np.broadcast_to(target.weight, target.values.shape)
    time = np.asarray(stimulus.time)
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
        upper=target.upper,
        quote=target.quote,
    )
