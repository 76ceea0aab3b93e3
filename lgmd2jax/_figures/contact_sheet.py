"""What a contact sheet shows of each condition: a few of its frames and its time course."""

import dataclasses

import numpy as np
from jaxtyping import Float, Int

from lgmd2jax.stimuli import Stimulus


@dataclasses.dataclass(frozen=True)
class Card:
    """One condition on a contact sheet.

    - `frames`, `shown`: some of its frames, and which of all they are.
    - `time`: of all frames, in ms.
    - `course`, `label`: what the stimulus did over time, with its name and unit.
    """

    name: str
    frames: Float[np.ndarray, "shown row col"]
    shown: Int[np.ndarray, " shown"]
    time: Float[np.ndarray, " time"]
    course: Float[np.ndarray, " time"]
    label: str

    @classmethod
    def of(cls, stimulus: Stimulus, count: int = 5) -> "Card":
        """The card of a stimulus, with `count` frames."""
        frames, time = np.asarray(stimulus.frames), np.asarray(stimulus.time)
        shown = _telling(frames, count)
        # Of several, the course in an angle says more than the one in pixels.
        course = min(stimulus.courses, key=lambda name: name.endswith("_px"))
        return cls(stimulus.name, frames[shown], shown, time, np.asarray(stimulus.courses[course]), _label(course))


def _telling(frames: Float[np.ndarray, "time row col"], count: int) -> Int[np.ndarray, " shown"]:
    """First, last, and frames between them, spaced a quarter by time and for the rest by how much the picture changes.

    What changes in most frames, such as a camera's noise, does not count.
    """
    change = np.abs(np.diff(frames, axis=0)).mean(axis=(1, 2))
    change = np.maximum(change - np.median(change), 0)
    progress = np.linspace(0, 1, len(frames))
    if change.any():
        progress = progress / 4 + np.append(0, np.cumsum(change)) / change.sum() * 3 / 4
    return np.searchsorted(progress, np.linspace(0, progress[-1], count)).clip(0, len(frames) - 1)


def _label(course: str) -> str:
    """Name and unit of a course, on two lines: "full_angle_deg" is a full angle in deg."""
    if course == "level":
        return "level\n(grey)"
    *words, unit = course.split("_")
    return f"{' '.join(words)}\n({unit})"
