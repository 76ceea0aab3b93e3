"""Bars that grow into the field or draw out of it by one moving edge: elongating, shortening."""

import equinox as eqx
import jax.numpy as jnp

from lgmd2jax._eye import Eye
from lgmd2jax._types import Scalar
from lgmd2jax.stimuli._arguments import extent_px
from lgmd2jax.stimuli._background import Background
from lgmd2jax.stimuli._family import family
from lgmd2jax.stimuli._scene import Trajectory, behind, look_from, sketch_object
from lgmd2jax.stimuli._segment import Segment, segment_from
from lgmd2jax.stimuli._stimulus import Sketch, frame_times
from lgmd2jax.stimuli._units import Degrees, DegreesPerSecond, GreyLevel, Pixels, PixelsPerSecond, WeberContrast


class _Bar(Trajectory):
    """A bar between an edge that runs along a segment, and the segment's start (it grows) or stop (it shrinks)."""

    segment: Segment
    half: Scalar
    direction: float | int = eqx.field(static=True)
    grows: bool = eqx.field(static=True)

    def __check_init__(self):
        if self.direction not in (0, 90, 180, 270):
            raise ValueError(
                f"direction is {self.direction!r} degrees; a bar lies along rows or columns: 0, 90, 180, 270"
            )

    def __call__(self, eye, time):
        position = self.segment.position(time)
        edge = self.segment.project(eye, position)
        end = jnp.broadcast_to(
            self.segment.project(eye, self.segment.start if self.grows else self.segment.stop), time.shape
        )
        back, front = (end, edge) if self.grows else (edge, end)
        if self.direction in (180, 270):
            back, front = -front, -back
        half = jnp.broadcast_to(self.half, time.shape)
        along, across = (back, front), (-half, half)
        bounds = (*across, *along) if self.direction in (90, 270) else (*along, *across)
        return jnp.stack(bounds, axis=1), {f"edge_{self.segment.unit}": position}


@family
def elongating(
    eye: Eye,
    *,
    width: Degrees = 16.0,
    width_px: Pixels | None = None,
    speed: DegreesPerSecond = 60.0,
    speed_px: PixelsPerSecond | None = None,
    start: Degrees = -40.0,
    start_px: Pixels | None = None,
    stop: Degrees = 40.0,
    stop_px: Pixels | None = None,
    direction: float | int = 0.0,
    contrast: WeberContrast = -0.9,
    level: GreyLevel | None = None,
    background: GreyLevel | Background = 200.0,
    start_ms: float | int | None = None,
    end_ms: float | int | None = None,
) -> Sketch:
    """A bar that grows from nothing by its leading edge. 0 ms is the onset of motion; it stands when it is full.

    **Arguments:**

    - `width`: of the bar across its direction, in degrees; or `width_px`.
    - `speed`, `start`, `stop`: of the edge, in deg/s and degrees from the middle; or `speed_px`, `start_px`, `stop_px`.
    - `direction`: of the edge's motion: 0, 90, 180 or 270 degrees (right, up, left, down).
    - `contrast` or `level`, `background`, `start_ms`, `end_ms`: as for `looming`.

    **Raises:** `ValueError` as for `looming`, for a bar wider than the field, and for an oblique direction.
    """
    segment = segment_from(speed=speed, start=start, stop=stop, speed_px=speed_px, start_px=start_px, stop_px=stop_px)
    half = extent_px(eye, "width", width, width_px) / 2
    ground = behind(background)
    time = frame_times(eye, start_ms, end_ms, 0.0, segment.duration_ms)
    return sketch_object(
        eye, time, ground, look_from(ground, contrast, level), _Bar(segment, half, direction, grows=True)
    )


@family
def shortening(
    eye: Eye,
    *,
    width: Degrees = 16.0,
    width_px: Pixels | None = None,
    speed: DegreesPerSecond = 60.0,
    speed_px: PixelsPerSecond | None = None,
    start: Degrees = -40.0,
    start_px: Pixels | None = None,
    stop: Degrees = 40.0,
    stop_px: Pixels | None = None,
    direction: float | int = 0.0,
    contrast: WeberContrast = -0.9,
    level: GreyLevel | None = None,
    background: GreyLevel | Background = 200.0,
    start_ms: float | int | None = None,
    end_ms: float | int | None = None,
) -> Sketch:
    """A bar that shrinks to nothing by its trailing edge. 0 ms is the onset of motion; it stands whole before.

    The edge moves just as in `elongating`, with the bar ahead of it instead of behind.

    **Arguments:** as for `elongating`.

    **Raises:** as for `elongating`.
    """
    segment = segment_from(speed=speed, start=start, stop=stop, speed_px=speed_px, start_px=start_px, stop_px=stop_px)
    half = extent_px(eye, "width", width, width_px) / 2
    ground = behind(background)
    time = frame_times(eye, start_ms, end_ms, 0.0, segment.duration_ms)
    return sketch_object(
        eye, time, ground, look_from(ground, contrast, level), _Bar(segment, half, direction, grows=False)
    )
