"""Objects that come and go in depth: looming, receding, approach and recession."""

import jax.numpy as jnp

from lgmd2jax._eye import Eye
from lgmd2jax._types import Scalar
from lgmd2jax.stimuli._approach import Approach, approach_from
from lgmd2jax.stimuli._arguments import number
from lgmd2jax.stimuli._background import Background
from lgmd2jax.stimuli._distance import Distance
from lgmd2jax.stimuli._family import family
from lgmd2jax.stimuli._scene import Trajectory, behind, boxes_around, look_from, place, sketch_object
from lgmd2jax.stimuli._stimulus import Sketch, frame_times
from lgmd2jax.stimuli._units import (
    Degrees,
    DegreesPerSecond,
    GreyLevel,
    Milliseconds,
    Pixels,
    PixelsPerSecond,
    PixelsPerSecond2,
    WeberContrast,
)


class _InApproach(Trajectory):
    """An object that is where its approach is, moved to the `right` and `up`."""

    approach: Approach
    right: Scalar
    up: Scalar

    def __call__(self, eye, time):
        right, up, sizes = self.approach(eye, time)
        return boxes_around(right + self.right, up + self.up, sizes["radius_px"]), sizes


@family
def looming(
    eye: Eye,
    *,
    l_over_v: Milliseconds = 40.0,
    growth: DegreesPerSecond | None = None,
    growth_px: PixelsPerSecond | None = None,
    acceleration_px: PixelsPerSecond2 = 0.0,
    distance: Distance | None = None,
    start_angle: Degrees = 2.0,
    stop_angle: Degrees = 80.0,
    start_radius_px: Pixels | None = None,
    stop_radius_px: Pixels | None = None,
    deviation: Degrees = 0.0,
    deviation_direction: Degrees = 0.0,
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
    """An object that approaches the eye; 0 ms is the collision. It stands before it starts, and where it stops.

    **Arguments:** how it comes, by one of

    - `l_over_v`: constant velocity, half-size by speed, in ms.
    - `growth`: a full angle that grows so many deg/s; 0 ms is the end of the motion.
    - `growth_px`: an edge that moves outward so many px/s, from `start_radius_px` to `stop_radius_px`, faster by
      `acceleration_px` in px/s2; 0 ms is the end of the motion. For screens that are known in pixels.
    - `distance`: any law, such as `Rolling()` or `Tabulated(time_ms, distance)`.

    From where to where:

    - `start_angle`, `stop_angle`: full angles in degrees, not for `growth_px`.
    - `deviation`: degrees between its motion and the line to the eye, from its start on; other than 0 it passes by.
    - `deviation_direction`: to which side, in degrees: 0 to the right, 90 above.
    - `azimuth`, `elevation`: where the picture of it all is centred, in degrees.

    What it looks like:

    - `contrast`: Weber, (object - background)/background, or `level`, its grey level 0..255.
    - `background`: grey level 0..255, or a `Background`, whose mean level the contrast then refers to.
    - `shape`: `"disc"`, or `"square"` of the same full angle from side to side.
    - `checks`: along a side, fixed to the object, 0 for none; every other one has `check_contrast` or
      `check_level`.

    When it is seen:

    - `start_ms`, `end_ms`: plain numbers; by default from 500 ms before the motion to 500 ms after it.

    **Raises:** `ValueError` for sizes, speeds and contrasts that cannot be, and for unknown names.
    """
    approach = approach_from(
        eye,
        l_over_v=l_over_v,
        growth=growth,
        growth_px=growth_px,
        acceleration_px=acceleration_px,
        distance=distance,
        start_angle=start_angle,
        stop_angle=stop_angle,
        start_radius_px=start_radius_px,
        stop_radius_px=stop_radius_px,
        deviation=deviation,
        deviation_direction=deviation_direction,
    )
    ground = behind(background)
    look = look_from(ground, contrast, level, shape, checks, check_contrast, check_level)
    centre = place(eye, azimuth, elevation)
    begin, end = approach.events()
    time = frame_times(eye, start_ms, end_ms, begin, end)
    return sketch_object(eye, time, ground, look, _InApproach(approach, *centre))


@family
def receding(
    eye: Eye,
    *,
    l_over_v: Milliseconds = 40.0,
    growth: DegreesPerSecond | None = None,
    growth_px: PixelsPerSecond | None = None,
    acceleration_px: PixelsPerSecond2 = 0.0,
    distance: Distance | None = None,
    start_angle: Degrees = 80.0,
    stop_angle: Degrees = 2.0,
    start_radius_px: Pixels | None = None,
    stop_radius_px: Pixels | None = None,
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
    """An object that draws away: an approach run backwards. 0 ms is the onset of motion; it stands before and after.

    **Arguments:** as for `looming`, with the larger `start_angle` (`start_radius_px`) and the smaller `stop_angle`.

    **Raises:** as for `looming`.
    """
    approach = approach_from(
        eye,
        l_over_v=l_over_v,
        growth=growth,
        growth_px=growth_px,
        acceleration_px=acceleration_px,
        distance=distance,
        start_angle=start_angle,
        stop_angle=stop_angle,
        start_radius_px=start_radius_px,
        stop_radius_px=stop_radius_px,
        recedes=True,
    )
    ground = behind(background)
    look = look_from(ground, contrast, level, shape, checks, check_contrast, check_level)
    centre = place(eye, azimuth, elevation)
    begin, end = approach.events()
    time = frame_times(eye, start_ms, end_ms, jnp.zeros_like(begin), end - begin)
    return sketch_object(eye, time, ground, look, _InApproach(approach, *centre), at=end - jnp.maximum(time, 0))


@family
def approach_recession(
    eye: Eye,
    *,
    l_over_v: Milliseconds = 40.0,
    growth: DegreesPerSecond | None = None,
    growth_px: PixelsPerSecond | None = None,
    acceleration_px: PixelsPerSecond2 = 0.0,
    distance: Distance | None = None,
    hold_ms: Milliseconds = 500.0,
    start_angle: Degrees = 2.0,
    stop_angle: Degrees = 80.0,
    start_radius_px: Pixels | None = None,
    stop_radius_px: Pixels | None = None,
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
    """An object that comes, stands for `hold_ms`, and goes the way it came. 0 ms is the collision of its approach.

    **Arguments:** as for `looming`, and

    - `hold_ms`: how long it stands where it is nearest, 0 or more.

    **Raises:** as for `looming`.
    """
    approach = approach_from(
        eye,
        l_over_v=l_over_v,
        growth=growth,
        growth_px=growth_px,
        acceleration_px=acceleration_px,
        distance=distance,
        start_angle=start_angle,
        stop_angle=stop_angle,
        start_radius_px=start_radius_px,
        stop_radius_px=stop_radius_px,
    )
    ground = behind(background)
    look = look_from(ground, contrast, level, shape, checks, check_contrast, check_level)
    centre = place(eye, azimuth, elevation)
    hold = number("hold_ms", hold_ms, Milliseconds, 0)
    begin, end = approach.events()
    turn = end + hold / 2
    time = frame_times(eye, start_ms, end_ms, begin, 2 * turn - begin)
    folded = turn - jnp.abs(time - turn)
    return sketch_object(eye, time, ground, look, _InApproach(approach, *centre), at=folded)
