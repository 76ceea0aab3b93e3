"""Objects that cross the field of view along a line."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import ScalarLike

from lgmd2jax._eye import Eye
from lgmd2jax._types import Scalar
from lgmd2jax.stimuli._arguments import extent_px, fits, number, one_of, positive, together
from lgmd2jax.stimuli._background import Background
from lgmd2jax.stimuli._family import family
from lgmd2jax.stimuli._scene import Path, behind, boxes, look, place, show
from lgmd2jax.stimuli._stimulus import Stimulus, frame_times
from lgmd2jax.stimuli._way import PROFILES, Way, way


class _Crossing(Path):
    """Along a way through a point `right` and `up` of the centre; one in cm passes the eye at a distance `away`."""

    way: Way
    profile: str = eqx.field(static=True)
    half: Scalar
    away: Scalar | None
    heading: Scalar
    right: Scalar
    up: Scalar

    def __call__(self, eye, time):
        position = self.way(time, self.profile)
        if self.away is None:
            along, half = self.way.project(eye, position), self.half
        elif eye.projection == "pinhole":
            # A flat object that faces the camera is as large wherever it is.
            along, half = eye.focal_px * position / self.away, eye.focal_px * self.half / self.away
        else:
            along = eye.project(jnp.degrees(jnp.arctan2(position, self.away)))
            half = eye.project(jnp.degrees(jnp.arctan2(self.half, jnp.hypot(position, self.away))))
        right, up = self.right + along * jnp.cos(self.heading), self.up + along * jnp.sin(self.heading)
        return boxes(right, up, jnp.broadcast_to(half, time.shape)), {f"position_{self.way.unit}": position}


@family
def translating(
    eye: Eye,
    *,
    speed: ScalarLike = 60.0,
    speed_px: ScalarLike | None = None,
    speed_cm_s: ScalarLike | None = None,
    size: ScalarLike = 10.0,
    size_px: ScalarLike | None = None,
    size_cm: ScalarLike | None = None,
    distance_cm: ScalarLike | None = None,
    start: ScalarLike = -40.0,
    start_px: ScalarLike | None = None,
    stop: ScalarLike = 40.0,
    stop_px: ScalarLike | None = None,
    direction: ScalarLike = 0.0,
    profile: str = "constant",
    azimuth: ScalarLike = 0.0,
    elevation: ScalarLike = 0.0,
    contrast: ScalarLike = -0.9,
    level: ScalarLike | None = None,
    background: ScalarLike | Background = 200.0,
    shape: str = "disc",
    checks: int = 0,
    check_contrast: ScalarLike = -0.45,
    check_level: ScalarLike | None = None,
    start_ms: float | int | None = None,
    end_ms: float | int | None = None,
) -> Stimulus:
    """An object that moves along a line across the field. 0 ms is the onset of motion; it stands before and after.

    **Arguments:** how large and how fast it is, in one of three units:

    - `size`, `speed`, `start`, `stop`: full angle in degrees, mean speed in deg/s, from and to which angle along its
      way, in degrees from the middle.
    - `size_px`, `speed_px`, `start_px`, `stop_px`: the same in pixels; `size_px` may stand alone.
    - `size_cm`, `speed_cm_s`, `distance_cm`: an object of some diameter that passes at a distance from the eye, on a
      straight path, between the angles `start` and `stop`.

    And

    - `direction`: of motion, in degrees: 0 to the right, 90 upwards.
    - `profile`: `"constant"` speed; `"linear"`, that grows with t; `"accelerating"`, with t^2; `"decelerating"`.
    - `azimuth`, `elevation`: the middle of its way, in degrees.
    - what it looks like, and when it is seen: as for `looming`.

    **Raises:** `ValueError` as for `looming`, for an object larger than the field, and for units that are mixed.
    """
    one_of("profile", profile, PROFILES)
    ground = behind(background)
    seen = look(ground, contrast, level, shape, checks, check_contrast, check_level)
    centre = place(eye, azimuth, elevation)
    heading = jnp.radians(number("direction", direction, "degrees"))
    if together(distance_cm=distance_cm, size_cm=size_cm, speed_cm_s=speed_cm_s):
        away, half = positive("distance_cm", distance_cm, "cm"), positive("size_cm", size_cm, "cm") / 2
        fits(eye, "size_cm", 2 * eye.project(jnp.degrees(jnp.arctan2(half, away))))
        first = away * jnp.tan(jnp.radians(number("start", start, "degrees", -89, 89)))
        last = away * jnp.tan(jnp.radians(number("stop", stop, "degrees", -89, 89)))
        path = Way(first, last, positive("speed_cm_s", speed_cm_s, "cm/s"), "cm")
    else:
        away, half = None, extent_px(eye, "size", size, size_px) / 2
        path = way(speed=speed, start=start, stop=stop, speed_px=speed_px, start_px=start_px, stop_px=stop_px)
    time = frame_times(eye, start_ms, end_ms, 0.0, path.duration_ms)
    return show(eye, time, ground, seen, _Crossing(path, profile, half, away, heading, *centre))
