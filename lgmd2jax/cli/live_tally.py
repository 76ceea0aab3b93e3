"""What came of a live source so far, in a memory that does not grow with time."""

import itertools
from collections import Counter, deque
from typing import NamedTuple

from lgmd2jax._video.trace import Row

_BIN_MS = 0.1
_WINDOW_S = 2.0  # over which the frame rate is told


class Moment(NamedTuple):
    """A frame that the model saw, and its answer.

    - `row`: the numbers that `lgmd2jax respond` writes.
    - `interval_ms`: since the frame before that it saw. `latency_ms`: from the frame's arrival to the answer.
    - `mp_sides`: MP of the left, centre and right third. `urgency`: of contact, NaN where the model tells none.
    """

    row: Row
    interval_ms: float
    latency_ms: float
    mp_sides: tuple[float, float, float]
    urgency: float

    def cells(self) -> tuple[float | int, ...]:
        """The row of the CSV file."""
        return (*self.row, self.interval_ms, self.latency_ms, *self.mp_sides, self.urgency)


COLUMNS = (*Row._fields, "interval_ms", "latency_ms", "mp_left", "mp_centre", "mp_right", "urgency")


class Tally:
    """Counts of frames and alarms, the frame rate of late, and how long answers took."""

    def __init__(self):
        self.frames, self.alarms, self.raised = 0, 0, False
        self._latencies: Counter[int] = Counter()  # by tenths of a ms
        self._times: deque[float] = deque()

    def add(self, moment: Moment) -> None:
        """Count a frame."""
        raised = bool(moment.row.collision)
        self.frames += 1
        self.alarms += raised and not self.raised
        self.raised = raised
        self._latencies[round(moment.latency_ms / _BIN_MS)] += 1
        self._times.append(moment.row.time_ms / 1000)
        while self._times[-1] - self._times[0] > _WINDOW_S:
            self._times.popleft()

    @property
    def fps(self) -> float:
        """Frames a second that the model saw of late."""
        lasted = self._times[-1] - self._times[0] if self._times else 0.0
        return (len(self._times) - 1) / lasted if lasted > 0 else 0.0

    def latency(self, share: float) -> float:
        """The latency in ms that this share of the frames does not exceed."""
        wanted = share * self.frames
        bins = sorted(self._latencies)
        for number, count in zip(bins, itertools.accumulate(self._latencies[number] for number in bins), strict=True):
            if count >= wanted:
                return number * _BIN_MS
        return 0.0
