"""What every renderer returns, frames with their times; and what a family knows before these are drawn."""

import math
from collections.abc import Callable
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, ScalarLike

from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._types import Times, is_concrete

MOST = 1000 * 2**29  # pixels of a clip, times ms in a second: 4 GiB in double precision
_SECONDS = 0.01  # relative: times so near to 1/fps apart are in s
LEAD_MS = 500.0  # of rest before the first motion, and after the last

Frames = Float[Array, "time row col"]
Courses = dict[str, Times]


@checked
class Stimulus(eqx.Module):
    """A clip, and what is known of it.

    - `frames`: grey levels, 0..255.
    - `fps`: frames per second.
    - `time`: of each frame in ms; 0 is the event (collision, onset of motion), and always falls on a frame.
    - `name`: the family that it belongs to.
    - `parameters`: the numbers that it was rendered with, by the names of the family's arguments; `noise`
      where a camera filmed.
    - `courses`: time courses of what was shown, by name with its unit, such as `"full_angle_deg"`.
    """

    frames: Float[Array, "time row col"]
    fps: float | int = eqx.field(static=True)
    time: Float[Array, " time"]
    name: str = eqx.field(static=True, default="")
    parameters: dict[str, Float[Array, ""]] = eqx.field(default_factory=dict)
    courses: dict[str, Float[Array, " time"]] = eqx.field(default_factory=dict)

    def __check_init__(self):
        if not (isinstance(self.fps, (int, float, np.number)) and math.isfinite(self.fps) and self.fps > 0):
            raise ValueError(f"fps is {self.fps!r}; give a positive number of frames per second")
        shape, times = np.shape(self.frames), np.shape(self.time)
        if len(shape) != 3 or times != shape[:1]:
            raise ValueError(f"frames has shape {shape} and time {times}; give (time, row, col), and a time a frame")
        if is_concrete(self.time) and times[0] > 1:
            usual = float(np.median(np.diff(self.time)))
            if math.isclose(usual, 1 / self.fps, rel_tol=_SECONDS):
                raise ValueError(f"time rises by {usual:.4g} a frame at {self.fps:g} fps, as in s; give it in ms")


class Sketch(NamedTuple):
    """A stimulus before its frames: the arguments are checked, the times are known."""

    time: Times
    draw: Callable[[], tuple[Frames, Courses]]


def frame_times(
    eye: Eye, start_ms: float | int | None, end_ms: float | int | None, begin: ScalarLike, end: ScalarLike
) -> Times:
    """Times i 1000/fps, i whole, of the window; by default from 500 ms before the motion's `begin` to 500 after `end`.

    **Raises:** `ValueError` for an empty window, and for a default one when `begin` or `end` is traced.
    """
    limits = []
    for name, limit, event, lead in (("start_ms", start_ms, begin, -LEAD_MS), ("end_ms", end_ms, end, LEAD_MS)):
        if limit is None and not is_concrete(event):
            raise ValueError(f"{name} is not given and would follow from a traced value; give a number for the batch")
        if limit is not None and not (isinstance(limit, (int, float)) and math.isfinite(limit)):
            raise ValueError(f"{name} is {limit!r}; give a plain number of ms")
        limits.append(float(np.asarray(event)) + lead if limit is None else limit)
    start, stop = limits
    if not (math.isfinite(start) and math.isfinite(stop) and (stop - start) * eye.fps * eye.rows * eye.cols < MOST):
        raise ValueError(
            f"start_ms {start:g} to end_ms {stop:g} at {eye.fps:g} fps makes more frames of {eye.rows} x {eye.cols} "
            "than memory holds; narrow the window, or take a coarser eye"
        )
    first = math.ceil(start * eye.fps / 1000 - 1e-6)
    last = math.floor(stop * eye.fps / 1000 + 1e-6)
    if last - first < 1:
        raise ValueError(
            f"start_ms {start:g} to end_ms {stop:g} holds fewer than 2 frames at {eye.fps:g} fps; widen it"
        )
    return jnp.asarray(np.arange(first, last + 1) * 1000 / eye.fps, dtype=float)
