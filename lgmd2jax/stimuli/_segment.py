"""A straight line across the field that is travelled from one end to the other, in degrees, pixels or centimetres."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array

from lgmd2jax._eye import Eye
from lgmd2jax._types import Scalar, Times, is_concrete
from lgmd2jax.stimuli._arguments import all_given, number, positive
from lgmd2jax.stimuli._units import Degrees, DegreesPerSecond, Pixels, PixelsPerSecond

# Share of the segment that is done after a share u of the time; the mean speed is the same for all.
PROFILES = {
    "constant": lambda u: u,
    "linear": lambda u: u**2,  # speed ~ t
    "accelerating": lambda u: u**3,  # speed ~ t^2
    "decelerating": lambda u: u * (2 - u),  # speed ~ T - t
}


class Segment(eqx.Module):
    """From `start` to `stop` at a mean `speed`, in a unit ("deg", "px", "cm") and that per second, from time 0 on."""

    start: Scalar
    stop: Scalar
    speed: Scalar
    unit: str = eqx.field(static=True)

    def __check_init__(self):
        if is_concrete(self.start, self.stop) and not self.start < self.stop:
            raise ValueError(f"start is {self.start:g} and stop {self.stop:g}; swap them, or turn the direction")

    @property
    def duration_ms(self) -> Scalar:
        """How long it takes."""
        return 1000 * (self.stop - self.start) / self.speed

    def position(self, time: Times, profile: str = "constant") -> Times:
        """Where one is at each time in ms."""
        return self.start + (self.stop - self.start) * PROFILES[profile](jnp.clip(time / self.duration_ms, 0, 1))

    def project(self, eye: Eye, position: Array) -> Array:
        """A position in pixels from the middle, for a segment in degrees or pixels."""
        return position if self.unit == "px" else eye.project(position)


def segment_from(
    *,
    speed: DegreesPerSecond,
    start: Degrees,
    stop: Degrees,
    speed_px: PixelsPerSecond | None,
    start_px: Pixels | None,
    stop_px: Pixels | None,
) -> Segment:
    """A segment in pixels, where that is asked for, or else in degrees.

    **Raises:** `ValueError` for a speed that is not positive, an end before the start, and for mixed units.
    """
    if all_given(speed_px=speed_px, start_px=start_px, stop_px=stop_px):
        first, last = number("start_px", start_px, Pixels), number("stop_px", stop_px, Pixels)
        return Segment(first, last, positive("speed_px", speed_px, PixelsPerSecond), "px")
    first, last = number("start", start, Degrees, -89, 89), number("stop", stop, Degrees, -89, 89)
    return Segment(first, last, positive("speed", speed, DegreesPerSecond), "deg")
