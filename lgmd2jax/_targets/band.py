"""A band that a response should lie in, from words that give no curve."""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from lgmd2jax._arguments.checked import checked
from lgmd2jax._arguments.units import has_unit
from lgmd2jax._channels import Channel
from lgmd2jax._targets.target import Target
from lgmd2jax.stimuli import Stimulus

Number = float | int


@checked
@dataclasses.dataclass(frozen=True, kw_only=True)
class Band:
    """A range in which the response should lie over time: the target where a paper gives words and no curve.

    A response within the range costs nothing. One outside differs by its distance from the nearer edge.

    ```python
    Band(low=0.5, high=0.6, quote="remains quiet")
    Band(segments_ms=[(0, 150), (300, 1000)], low=[0.55, 0.5], high=[0.8, 0.55], quote="briefly excited")
    ```

    **Arguments:**

    - `low`, `high`: the edges, in the unit of the channel; one number throughout, or one for each segment of time.
      `-inf` and `inf` leave a side open.
    - `segments_ms`: start and end of each segment, the end excluded. Between them nothing counts. Without them there is
      one, the whole stimulus.
    - `channel`: as of a `Target`.
    - `quote`: the words that the band stands for; a report counts all bands of the same words together.

    **Raises:** `ValueError` for an unknown channel, for lists of unequal lengths, for segments that do not follow each
    other, for a lower edge above the upper one, and for a segment without a finite edge.
    """

    low: Number | Sequence[Number]
    high: Number | Sequence[Number]
    segments_ms: Sequence[Sequence[Number]] | None = None
    channel: Channel = "smp_adapted"
    quote: str = ""

    def __post_init__(self):
        if has_unit(self.segments_ms):
            raise ValueError(f"segments_ms is {self.segments_ms!r:.60}; give plain numbers of ms")
        if not _follow_each_other(self._segments):
            raise ValueError(f"segments_ms is {self.segments_ms}; give [start, end] of each in ms, one after the other")
        for number, (low, high) in enumerate(zip(self._edge("low"), self._edge("high"), strict=True), start=1):
            if low > high:
                raise ValueError(f"low is {low:g} and high {high:g} in segment {number}; swap them")
            if not (math.isfinite(low) or math.isfinite(high)) or low == math.inf or high == -math.inf:
                raise ValueError(f"low is {low:g} and high {high:g} in segment {number}; give a finite edge")

    @checked
    def on(self, stimulus: Stimulus) -> Target:
        """The target at the frames of the stimulus, with weight 0 outside of the segments.

        **Raises:** `ValueError` for a segment that holds no frame.
        """
        time = np.asarray(stimulus.time, dtype=float)
        low, high, weight = (np.zeros(len(time)) for _ in range(3))
        for (start, end), lower, upper in zip(self._segments, self._edge("low"), self._edge("high"), strict=True):
            inside = (time >= start) & (time < end)
            if not inside.any():
                raise ValueError(
                    f"the segment from {start:g} to {end:g} ms holds no frame; "
                    f"the stimulus covers {time[0]:g} to {time[-1]:g} ms"
                )
            low[inside], high[inside], weight[inside] = lower, upper, 1.0
        return Target(self.channel, low, upper=high, weight=weight, quote=self.quote).on(stimulus)

    @property
    def _segments(self) -> Sequence[Sequence[Number]]:
        return [(-math.inf, math.inf)] if self.segments_ms is None else self.segments_ms

    def _edge(self, name: str) -> list[Number]:
        """The edge in each segment."""
        edge, count = getattr(self, name), len(self._segments)
        levels = list(edge) if isinstance(edge, Sequence) else [edge] * count
        if len(levels) != count:
            raise ValueError(f"{name} has {len(levels)} values and there are {count} segments; give one for each")
        for level in levels:
            if not isinstance(level, (int, float)) or math.isnan(level):
                raise ValueError(f"{name} holds {level!r}; give numbers")
        return levels


def _follow_each_other(segments: Sequence[Sequence[Number]]) -> bool:
    """Whether these are pairs of times, none of which starts before the last one ended."""
    if not isinstance(segments, Sequence) or not all(isinstance(segment, Sequence) for segment in segments):
        return False
    times = [time for segment in segments for time in segment]
    in_pairs = all(len(segment) == 2 and segment[0] < segment[1] for segment in segments)
    return bool(times) and in_pairs and times == sorted(times)
