"""Repeated frames: what frame-rate conversion and a camera that stalls leave in a file."""

import numpy as np
from jaxtyping import Bool, Float

REACH = 8
RATIO = 0.3
RULE = f"changed by less than {RATIO:g} of the second largest change in {REACH} frames before, and in {REACH} after"


def find_repeats(changes: Float[np.ndarray, " time"]) -> Bool[np.ndarray, " time"]:
    """Which frames repeat the frame before them, from how much each changes.

    No threshold on the change itself will do: a compressed repeat still changes by its coding noise, and a quiet scene
    changes less than a repeat in a lively one. A repeat is a dip: the change is below `RATIO` of what is usual on both
    sides. What is usual is the second largest change within `REACH` frames: the largest may be a key frame, and two
    frames of three may be repeats. A scene that stands still, or comes to rest, has no dips and keeps its frames.

    **Arguments:** `changes`: mean absolute difference to the frame before, in grey levels; the first is not looked at.
    """
    repeats = np.zeros(len(changes), bool)
    if len(changes) > 1:
        known = changes[1:]
        windows = np.lib.stride_tricks.sliding_window_view(np.pad(known, REACH, mode="symmetric"), REACH)
        usual = np.sort(windows, axis=1)[:, -2]
        before, after = usual[: len(known)], usual[REACH + 1 :]
        repeats[1:] = known < RATIO * np.minimum(before, after)
    return repeats
