"""A band that a response should lie in, from words that give no curve."""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from lgmd2jax._channels import Channel
from lgmd2jax._targets.target import Target, check_channel
from lgmd2jax.stimuli import Stimulus

Level = float | int


@dataclasses.dataclass(frozen=True, kw_only=True)
class Band:
    """The range of a response over time: what a sentence tells that gives no curve.

    A response within differs by nothing; one outside by its distance from the nearer edge.

    ```python
    Band(low=0.5, high=0.6, quote="remains quiet")
    Band(starts_ms=[-500, 0, 300], low=[0.5, 0.55, 0.5], high=[0.52, 0.8, 0.55])
    ```

    **Arguments:**

    - `low`, `high`: the edges, in the unit of the channel; one number throughout, or one for each segment of time.
      `-inf` and `inf` leave a side open.
    - `starts_ms`: when each segment starts, to last until the next one or the end of the stimulus. Before the first
      nothing counts. Without it there is one segment, the whole stimulus.
    - `channel`: as of a `Target`.
    - `quote`: the words that the band stands for; a report counts all bands of the same words together.

    **Raises:** `ValueError` for an unknown channel, for lists of unequal lengths, for starts that do not increase, for
    a lower edge above the upper one, and for a segment without a finite edge.
    """

    low: Level | Sequence[Level]
    high: Level | Sequence[Level]
    starts_ms: Sequence[Level] | None = None
    channel: Channel = "smp_adapted"
    quote: str = ""

    def __post_init__(self):
        check_channel(self.channel)
        starts = self._starts
        if not starts.size or np.isnan(starts).any() or np.any(np.diff(starts) <= 0):
            raise ValueError(f"starts_ms is {self.starts_ms}; give times in ms that increase")
        low, high = (self._segments(name) for name in ("low", "high"))
        for segment, (lower, upper) in enumerate(zip(low, high, strict=True), start=1):
            if lower > upper:
                raise ValueError(f"low is {lower:g} and high {upper:g} in segment {segment}; swap them")
            if not (math.isfinite(lower) or math.isfinite(upper)) or lower == math.inf or upper == -math.inf:
                raise ValueError(f"low is {lower:g} and high {upper:g} in segment {segment}; give a finite edge")

    def on(self, stimulus: Stimulus) -> Target:
        """The target at the frames of the stimulus, with weight 0 before the first segment.

        **Raises:** `ValueError` for a segment that holds no frame.
        """
        time, starts = np.asarray(stimulus.time, dtype=float), self._starts
        segment = np.searchsorted(starts, time, side="right") - 1
        for number, start in enumerate(starts):
            if not np.any(segment == number):
                raise ValueError(
                    f"the segment from {start:g} ms holds no frame; the stimulus covers {time[0]:g} to {time[-1]:g} ms"
                )
        low, high = (np.array(self._segments(name))[segment.clip(min=0)] for name in ("low", "high"))
        return Target(self.channel, low, upper=high, weight=np.where(segment < 0, 0.0, 1.0), quote=self.quote).on(
            stimulus
        )

    @property
    def _starts(self) -> np.ndarray:
        return np.atleast_1d(np.asarray(-math.inf if self.starts_ms is None else self.starts_ms, dtype=float))

    def _segments(self, name: str) -> list[float]:
        """An edge in each segment."""
        edge, count = getattr(self, name), len(self._starts)
        levels = list(edge) if isinstance(edge, Sequence) else [edge] * count
        if len(levels) != count:
            raise ValueError(f"{name} has {len(levels)} values and there are {count} segments; give one for each")
        for level in levels:
            if not isinstance(level, (int, float)) or math.isnan(level):
                raise ValueError(f"{name} holds {level!r}; give numbers")
        return [float(level) for level in levels]
