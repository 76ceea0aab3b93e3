"""A clip as a whole: the clock of its frames, and the decoded frames that a fit sees."""

import dataclasses

import numpy as np
from jaxtyping import Float, Float32, Int


def time_of(frame: int, index: Int[np.ndarray, " time"], time: Float[np.ndarray, " time"]) -> float:
    """When a frame of a file is shown, in ms. After the last known frame the usual interval goes on.

    **Arguments:** `index`, `time`: where each known frame stands in the file, and when, in ms.
    """
    beyond = max(frame - int(index[-1]), 0)
    usual = (time[-1] - time[0]) / max(index[-1] - index[0], 1)
    return float(np.interp(frame, index, time) + beyond * usual)


@dataclasses.dataclass(frozen=True)
class Timeline:
    """When the frames of a clip are shown, perhaps without its repeated ones.

    - `index`, `time`: where each frame stands in the file, and when, in ms.
    - `interval`: ms since the frame before, for the model's time constants.
    - `fps`: frames per second, after repeated frames were dropped.
    - `count`: how many frames the file holds, repeated ones included.
    """

    index: Int[np.ndarray, " time"]
    time: Float[np.ndarray, " time"]
    interval: Float[np.ndarray, " time"]
    fps: float
    count: int

    def time_of(self, frame: int) -> float:
        """When a frame of the file is shown, in ms, or would be after the clip's end."""
        return time_of(frame, self.index, self.time)

    def frame_at(self, time: float) -> int:
        """The frame of the file that is nearest to a time, within the clip."""
        return round(float(np.interp(time, self.time, self.index)))


@dataclasses.dataclass(frozen=True)
class Recording(Timeline):
    """The grey frames of a clip with their times, perhaps without its repeated ones."""

    frames: Float32[np.ndarray, "time row col"]
