"""How an object comes nearer: where it is over time and how large, in depth or on a screen."""

import abc

import equinox as eqx
import jax.numpy as jnp

from lgmd2jax._eye import Eye
from lgmd2jax._types import Scalar, Times, is_concrete
from lgmd2jax.stimuli._arguments import all_given, check_fits, number, positive
from lgmd2jax.stimuli._distance import AngleGrowth, ConstantVelocity, Distance
from lgmd2jax.stimuli._units import (
    Degrees,
    DegreesPerSecond,
    Milliseconds,
    Pixels,
    PixelsPerSecond,
    PixelsPerSecond2,
    unit_of,
)

_NEAREST = 1e-3  # half-sizes before a lens; what is nearer cannot be seen whole


class Approach(eqx.Module):
    """The motion of an object from one size to a larger one; it stands before and after."""

    @abc.abstractmethod
    def events(self) -> tuple[Scalar, Scalar]:
        """When the motion begins and ends, in ms."""

    @abc.abstractmethod
    def __call__(self, eye: Eye, time: Times) -> tuple[Times, Times, dict[str, Times]]:
        """Centre to the right and above, in pixels; sizes over time by name, `"radius_px"` among them."""


class InDepth(Approach):
    """Along a straight line that starts on the axis, at angle `small`, and misses the eye by an angle of `deviation`.

    Lengths are in half-sizes of the object.
    """

    law: Distance
    small: Scalar
    large: Scalar
    deviation: Scalar
    direction: Scalar

    def events(self):
        return self.law.reached(_distance(self.small)), self.law.reached(_distance(self.large))

    def __call__(self, eye, time):
        start, stop = _distance(self.small), _distance(self.large)
        aside, ahead = jnp.sin(jnp.radians(self.deviation)), jnp.cos(jnp.radians(self.deviation))
        miss = start * aside
        arrives = jnp.abs(miss) < stop
        arrival = start * ahead - jnp.sqrt(jnp.where(arrives, stop**2 - miss**2, 1))
        progress = jnp.clip(start - self.law(time), 0, jnp.where(arrives, arrival, jnp.inf))
        depth, offset = start - progress * ahead, progress * aside
        half_angle = jnp.degrees(jnp.arctan2(1, jnp.sqrt(depth**2 + offset**2)))
        if eye.projection == "pinhole":
            # The object is flat and faces the camera, so that its image keeps its shape; it goes as it passes the lens.
            before = jnp.maximum(depth, _NEAREST)
            along = eye.focal_px * offset / before
            radius = jnp.where(depth > 0, eye.focal_px / before, 0)
        else:
            along = eye.project(jnp.degrees(jnp.arctan2(offset, depth)))
            radius = eye.project(half_angle)
        heading = jnp.radians(self.direction)
        centre = jnp.stack([along * jnp.cos(heading), along * jnp.sin(heading)])
        return centre[0], centre[1], {"radius_px": radius, "full_angle_deg": 2 * half_angle}


class OnScreen(Approach):
    """The edge moves outward by `growth` px/s, faster by `acceleration` px/s2, until time 0."""

    growth: Scalar
    acceleration: Scalar
    small: Scalar
    large: Scalar

    def events(self):
        outward = self.large - self.small
        final = jnp.sqrt(self.growth**2 + 2 * self.acceleration * outward)
        return -2000 * outward / (self.growth + final), jnp.zeros_like(outward)

    def __call__(self, eye, time):
        begin, end = self.events()
        since = jnp.clip(time - begin, 0, end - begin) / 1000
        radius = self.small + (self.growth + self.acceleration / 2 * since) * since
        return jnp.zeros_like(radius), jnp.zeros_like(radius), {"radius_px": radius}


def approach_from(
    eye: Eye,
    *,
    l_over_v: Milliseconds,
    growth: DegreesPerSecond | None,
    growth_px: PixelsPerSecond | None,
    acceleration_px: PixelsPerSecond2,
    distance: Distance | None,
    start_angle: Degrees,
    stop_angle: Degrees,
    start_radius_px: Pixels | None,
    stop_radius_px: Pixels | None,
    deviation: Degrees = 0.0,
    deviation_direction: Degrees = 0.0,
    recedes: bool = False,
) -> Approach:
    """The approach that the arguments of `looming` ask for; one that `recedes` is to be run backwards.

    **Raises:** `ValueError` where they contradict each other or cannot be.
    """
    on_screen = all_given(growth_px=growth_px, start_radius_px=start_radius_px, stop_radius_px=stop_radius_px)
    if on_screen:
        sizes, quantity = {"start_radius_px": start_radius_px, "stop_radius_px": stop_radius_px}, Pixels
    else:
        sizes, quantity = {"start_angle": start_angle, "stop_angle": stop_angle}, Degrees
    small_name, large_name = reversed(sizes) if recedes else sizes
    small = positive(small_name, sizes[small_name], quantity)
    large = positive(large_name, sizes[large_name], quantity, jnp.inf if on_screen else 179)
    if is_concrete(small, large) and not small < large:
        unit = unit_of(quantity).name
        raise ValueError(f"{large_name} is {large:g} {unit} and {small_name} {small:g}; make {large_name} the larger")
    if on_screen:
        return _on_screen(eye, growth_px, acceleration_px, small, large, small_name)

    check_fits(eye, small_name, 2 * eye.project(small / 2))
    deviation = number("deviation", deviation, Degrees, -89, 89)
    direction = number("deviation_direction", deviation_direction, Degrees)
    if distance is not None:
        if not isinstance(distance, Distance):
            raise ValueError(f"distance is {distance!r}; give a Distance such as Rolling()")
        law = distance
    elif growth is not None:
        law = AngleGrowth(positive("growth", growth, DegreesPerSecond), large)
    else:
        law = ConstantVelocity(positive("l_over_v", l_over_v, Milliseconds))
    return InDepth(law, small, large, deviation, direction)


def _on_screen(
    eye: Eye,
    growth_px: PixelsPerSecond | None,
    acceleration_px: PixelsPerSecond2,
    small: Scalar,
    large: Scalar,
    small_name: str,
) -> Approach:
    check_fits(eye, small_name, 2 * small)
    growth = positive("growth_px", growth_px, PixelsPerSecond)
    acceleration = number("acceleration_px", acceleration_px, PixelsPerSecond2)
    if is_concrete(growth, acceleration, small, large) and growth**2 + 2 * acceleration * (large - small) <= 0:
        raise ValueError(f"acceleration_px is {acceleration:g} px/s2: the edge stops on its way; slow it less")
    return OnScreen(growth, acceleration, small, large)


def _distance(full_angle: Scalar) -> Scalar:
    """Distance at which an object has a full angle in degrees."""
    return 1 / jnp.tan(jnp.radians(full_angle) / 2)
