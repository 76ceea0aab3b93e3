"""What a film is made from: chance, and the moments at which the camera looks."""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

Course = Float[np.ndarray, " time"]


@dataclasses.dataclass(frozen=True)
class Shot:
    """A source of chance, and the time of each frame in s. How much chance is used does not depend on the times."""

    chance: np.random.Generator
    time: Course

    def between(self, low: float | int, high: float | int) -> float:
        """A random number between two."""
        return float(self.chance.uniform(low, high))

    def log(self, low: float | int, high: float | int) -> float:
        """The same, its logarithm uniform."""
        return math.exp(self.chance.uniform(math.log(low), math.log(high)))

    def often(self, share: float | int) -> bool:
        """True in this share of the films."""
        return bool(self.chance.random() < share)

    def side(self) -> int:
        """-1 or 1."""
        return int(self.chance.choice([-1, 1]))

    @property
    def lasts(self) -> float:
        """Until when, in s."""
        return float(self.time[-1])

    @property
    def still(self) -> Course:
        """Zero in each frame."""
        return np.zeros_like(self.time)

    def sway(self, size: float | int, slowest_hz: float | int, fastest_hz: float | int) -> Course:
        """A restless course of this root mean square: three swings."""
        rates, phases = [self.log(slowest_hz, fastest_hz) for _ in range(3)], self.chance.random(3)
        return size * np.sqrt(2 / 3) * swings(self.time, rates, phases)


def swings(
    time: Float[np.ndarray, "*time"], rates_hz: Sequence[float], phases: Float[np.ndarray, "swing *place"]
) -> Float[np.ndarray, "*course"]:
    """The sum of sines of amplitude 1; phases are in turns."""
    sines = [np.sin(2 * np.pi * (rate * time + phase)) for rate, phase in zip(rates_hz, phases, strict=True)]
    return np.sum(sines, axis=0)
