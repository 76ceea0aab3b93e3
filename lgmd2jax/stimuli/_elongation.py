"""Bars that grow into the field or draw out of it by one moving edge: elongating, shortening."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import ScalarLike

from lgmd2jax._eye import Eye
from lgmd2jax._types import Scalar
from lgmd2jax.stimuli._arguments import extent_px
from lgmd2jax.stimuli._background import Background
from lgmd2jax.stimuli._family import family
from lgmd2jax.stimuli._scene import Path, behind, look, show
from lgmd2jax.stimuli._stimulus import Stimulus, frame_times
from lgmd2jax.stimuli._way import Way, way


class _Bar(Path):
    """Between an edge that runs along a way, and the start of that way (it grows) or its end (it shrinks)."""

    way: Way
    half: Scalar
    direction: float | int = eqx.field(static=True)
    grows: bool = eqx.field(static=True)

    def __check_init__(self):
        if self.direction not in (0, 90, 180, 270):
            raise ValueError(
                f"direction is {self.direction!r} degrees; a bar lies along rows or columns: 0, 90, 180, 270"
            )

    def __call__(self, eye, time):
        position = self.way(time)
        edge = self.way.project(eye, position)
        end = jnp.broadcast_to(self.way.project(eye, self.way.start if self.grows else self.way.stop), time.shape)
        back, front = (end, edge) if self.grows else (edge, end)
        if self.direction in (180, 270):
            back, front = -front, -back
        half = jnp.broadcast_to(self.half, time.shape)
        along, across = (back, front), (-half, half)
        bounds = (*across, *along) if self.direction in (90, 270) else (*along, *across)
        return jnp.stack(bounds, axis=1), {f"edge_{self.way.unit}": position}


@family
def elongating(
    eye: Eye,
    *,
    width: ScalarLike = 16.0,
    width_px: ScalarLike | None = None,
    speed: ScalarLike = 60.0,
    speed_px: ScalarLike | None = None,
    start: ScalarLike = -40.0,
    start_px: ScalarLike | None = None,
    stop: ScalarLike = 40.0,
    stop_px: ScalarLike | None = None,
    direction: float | int = 0.0,
    contrast: ScalarLike = -0.9,
    level: ScalarLike | None = None,
    background: ScalarLike | Background = 200.0,
    start_ms: float | int | None = None,
    end_ms: float | int | None = None,
) -> Stimulus:
    """A bar that grows from nothing by its leading edge. 0 ms is the onset of motion; it stands when it is full.

    **Arguments:**

    - `width`: of the bar across its direction, in degrees; or `width_px`.
    - `speed`, `start`, `stop`: of the edge, in deg/s and degrees from the middle; or `speed_px`, `start_px`, `stop_px`.
    - `direction`: of the edge's motion: 0, 90, 180 or 270 degrees (right, up, left, down).
    - `contrast` or `level`, `background`, `start_ms`, `end_ms`: as for `looming`.

    **Raises:** `ValueError` as for `looming`, for a bar wider than the field, and for an oblique direction.
    """
    path = way(speed=speed, start=start, stop=stop, speed_px=speed_px, start_px=start_px, stop_px=stop_px)
    half = extent_px(eye, "width", width, width_px) / 2
    ground = behind(background)
    time = frame_times(eye, start_ms, end_ms, 0.0, path.duration_ms)
    return show(eye, time, ground, look(ground, contrast, level), _Bar(path, half, direction, grows=True))


@family
def shortening(
    eye: Eye,
    *,
    width: ScalarLike = 16.0,
    width_px: ScalarLike | None = None,
    speed: ScalarLike = 60.0,
    speed_px: ScalarLike | None = None,
    start: ScalarLike = -40.0,
    start_px: ScalarLike | None = None,
    stop: ScalarLike = 40.0,
    stop_px: ScalarLike | None = None,
    direction: float | int = 0.0,
    contrast: ScalarLike = -0.9,
    level: ScalarLike | None = None,
    background: ScalarLike | Background = 200.0,
    start_ms: float | int | None = None,
    end_ms: float | int | None = None,
) -> Stimulus:
    """A bar that shrinks to nothing by its trailing edge. 0 ms is the onset of motion; it stands whole before.

    The edge moves just as in `elongating`, with the bar ahead of it instead of behind.

    **Arguments:** as for `elongating`.

    **Raises:** as for `elongating`.
    """
    path = way(speed=speed, start=start, stop=stop, speed_px=speed_px, start_px=start_px, stop_px=stop_px)
    half = extent_px(eye, "width", width, width_px) / 2
    ground = behind(background)
    time = frame_times(eye, start_ms, end_ms, 0.0, path.duration_ms)
    return show(eye, time, ground, look(ground, contrast, level), _Bar(path, half, direction, grows=False))
