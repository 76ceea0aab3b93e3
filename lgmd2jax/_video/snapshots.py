"""A handful of pictures, spread evenly over a clip whose length is not known beforehand."""

import dataclasses
from collections.abc import Callable

from lgmd2jax._video.grey import Picture


@dataclasses.dataclass(frozen=True)
class Snapshot:
    """A small copy of a picture: the frame that it shows, its time in ms, and whether the alarm was on."""

    frame: int
    time: float
    alarm: bool
    picture: Picture


class Snapshots:
    """Keeps at most `4 * COUNT` pictures: when more have come, every second one goes, and the stride doubles."""

    COUNT = 8
    WIDTH = 240

    def __init__(self):
        self._kept: list[Snapshot] = []
        self._first_alarm: Snapshot | None = None
        self._offered = 0
        self._stride = 1

    def offer(self, frame: int, time: float, alarm: bool, picture: Callable[[], Picture]) -> None:
        """Take the next frame of the clip, or leave it; the picture is asked for only when it is taken."""
        wanted, first_alarm = self._offered % self._stride == 0, alarm and self._first_alarm is None
        self._offered += 1
        if not (wanted or first_alarm):
            return
        whole = picture()
        step = max(1, whole.shape[1] // self.WIDTH)
        snapshot = Snapshot(frame, time, alarm, whole[::step, ::step].copy())
        if first_alarm:
            self._first_alarm = snapshot
        if wanted:
            self._kept.append(snapshot)
        if len(self._kept) > 4 * self.COUNT:
            self._kept = self._kept[::2]
            self._stride *= 2

    def chosen(self) -> list[Snapshot]:
        """At most `COUNT` of them, evenly spread; the first alarm takes the place of its nearest neighbour."""
        last, gaps = len(self._kept) - 1, min(self.COUNT, len(self._kept)) - 1
        chosen = [self._kept[round(i * last / gaps)] for i in range(gaps + 1)] if gaps > 0 else list(self._kept)
        if (alarm := self._first_alarm) is not None:
            nearest = min(range(len(chosen)), key=lambda i: abs(chosen[i].frame - alarm.frame))
            chosen[nearest] = alarm
        return chosen
