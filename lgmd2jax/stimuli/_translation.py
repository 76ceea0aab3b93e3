"""Objects that cross the field of view along a line."""

import equinox as eqx
import jax.numpy as jnp

from lgmd2jax._eye import Eye
from lgmd2jax._types import Scalar
from lgmd2jax.stimuli._arguments import all_given, check_fits, extent_px, number, one_of, positive
from lgmd2jax.stimuli._background import Background
from lgmd2jax.stimuli._family import family
from lgmd2jax.stimuli._scene import Trajectory, behind, boxes_around, look_from, place, sketch_object
from lgmd2jax.stimuli._segment import PROFILES, Segment, segment_from
from lgmd2jax.stimuli._stimulus import Sketch, frame_times
from lgmd2jax.stimuli._units import (
    Centimetres,
    CentimetresPerSecond,
    Degrees,
    DegreesPerSecond,
    GreyLevel,
    Pixels,
    PixelsPerSecond,
    WeberContrast,
)


class _Crossing(Trajectory):
    """Along a segment about a point `right` and `up` of the centre; one in cm passes the eye at a distance `away`."""

    segment: Segment
    profile: str = eqx.field(static=True)
    half: Scalar
    away: Scalar | None
    heading: Scalar
    right: Scalar
    up: Scalar

    def __call__(self, eye, time):
        position = self.segment.position(time, self.profile)
        if self.away is None:
            along, half = self.segment.project(eye, position), self.half
        elif eye.projection == "pinhole":
            # A flat object that faces the camera is as large wherever it is.
            along, half = eye.focal_px * position / self.away, eye.focal_px * self.half / self.away
        else:
            along = eye.project(jnp.degrees(jnp.arctan2(position, self.away)))
            half = eye.project(jnp.degrees(jnp.arctan2(self.half, jnp.hypot(position, self.away))))
        right, up = self.right + along * jnp.cos(self.heading), self.up + along * jnp.sin(self.heading)
        return boxes_around(right, up, jnp.broadcast_to(half, time.shape)), {f"position_{self.segment.unit}": position}


@family
def translating(
    eye: Eye,
    *,
    speed: DegreesPerSecond = 60.0,
    speed_px: PixelsPerSecond | None = None,
    speed_cm_s: CentimetresPerSecond | None = None,
    size: Degrees = 10.0,
    size_px: Pixels | None = None,
    size_cm: Centimetres | None = None,
    distance_cm: Centimetres | None = None,
    start: Degrees = -40.0,
    start_px: Pixels | None = None,
    stop: Degrees = 40.0,
    stop_px: Pixels | None = None,
    direction: Degrees = 0.0,
    profile: str = "constant",
    azimuth: Degrees = 0.0,
    elevation: Degrees = 0.0,
    contrast: WeberContrast = -0.9,
    level: GreyLevel | None = None,
    background: GreyLevel | Background = 200.0,
    shape: str = "disc",
    checks: int = 0,
    check_contrast: WeberContrast = -0.45,
    check_level: GreyLevel | None = None,
    start_ms: float | int | None = None,
    end_ms: float | int | None = None,
) -> Sketch:
    """An object that moves along a line across the field. 0 ms is the onset of motion; it stands before and after.

    **Arguments:** how large and how fast it is, in one of three units:

    - `size`, `speed`, `start`, `stop`: full angle in degrees, mean speed in deg/s, from and to which angle along its
      line, in degrees from the middle.
    - `size_px`, `speed_px`, `start_px`, `stop_px`: the same in pixels; `size_px` may stand alone.
    - `size_cm`, `speed_cm_s`, `distance_cm`: an object of some diameter that passes at a distance from the eye, on a
      straight line, between the angles `start` and `stop`.

    And

    - `direction`: of motion, in degrees: 0 to the right, 90 upwards.
    - `profile`: `"constant"` speed; `"linear"`, that grows with t; `"accelerating"`, with t^2; `"decelerating"`.
    - `azimuth`, `elevation`: the middle of its line, in degrees.
    - what it looks like, and when it is seen: as for `looming`.

    **Raises:** `ValueError` as for `looming`, for an object larger than the field, and for units that are mixed.
    """
    one_of("profile", profile, PROFILES)
    ground = behind(background)
    look = look_from(ground, contrast, level, shape, checks, check_contrast, check_level)
    centre = place(eye, azimuth, elevation)
    heading = jnp.radians(number("direction", direction, Degrees))
    if all_given(distance_cm=distance_cm, size_cm=size_cm, speed_cm_s=speed_cm_s):
        away, half = positive("distance_cm", distance_cm, Centimetres), positive("size_cm", size_cm, Centimetres) / 2
        check_fits(eye, "size_cm", 2 * eye.project(jnp.degrees(jnp.arctan2(half, away))))
        first = away * jnp.tan(jnp.radians(number("start", start, Degrees, -89, 89)))
        last = away * jnp.tan(jnp.radians(number("stop", stop, Degrees, -89, 89)))
        segment = Segment(first, last, positive("speed_cm_s", speed_cm_s, CentimetresPerSecond), "cm")
    else:
        away, half = None, extent_px(eye, "size", size, size_px) / 2
        segment = segment_from(
            speed=speed, start=start, stop=stop, speed_px=speed_px, start_px=start_px, stop_px=stop_px
        )
    time = frame_times(eye, start_ms, end_ms, 0.0, segment.duration_ms)
    return sketch_object(eye, time, ground, look, _Crossing(segment, profile, half, away, heading, *centre))
