"""What lies behind the object: a grey level, a photograph, a panorama."""

import abc
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._types import Map
from lgmd2jax.stimuli import _texture as texture
from lgmd2jax.stimuli._arguments import number
from lgmd2jax.stimuli._units import Degrees, DegreesPerSecond, Factor, GreyLevel


class Background(eqx.Module):
    """What lies behind the object."""

    @property
    @abc.abstractmethod
    def mean_level(self) -> Float[Array, ""]:
        """The grey level that Weber contrast refers to."""

    @abc.abstractmethod
    def painter(self, eye: Eye) -> Callable[[Float[Array, ""]], Map]:
        """A function that gives the frame at a time in ms."""


@checked
class Uniform(Background):
    """One grey level, 0..255.

    **Raises:** `ValueError` for a level outside of 0..255.
    """

    level: Float[Array, ""] = eqx.field(
        default=200.0, converter=lambda level: number("background", level, GreyLevel, 0, 255)
    )

    @property
    def mean_level(self):
        return self.level

    def painter(self, eye):
        return lambda time: jnp.full((eye.rows, eye.cols), self.level)


def _level(level):
    return None if level is None else number("level", level, GreyLevel, 0, 255)


def _contrast(contrast):
    return number("contrast", contrast, Factor, 0)


def _speed(speed):
    return None if speed is None else number("speed", speed, DegreesPerSecond)


def _width(width) -> float:
    """Plain Python: it decides the size of the texture."""
    if not (isinstance(width, (int, float)) and 0 < width <= 180):
        raise ValueError(f"width is {width!r} degrees; give a plain number in 0..180")
    return float(width)


@checked
class Photograph(Background):
    """A flat picture, which may drift; beyond its borders it is mirrored.

    **Arguments:**

    - `image`: a name in scikit-image's wheel (`PHOTOGRAPHS`), a path to an image, or grey levels 0..255 as an array.
    - `level`: mean grey level, by multiplication; the picture's own by default.
    - `contrast`: factor on the deviations from the mean.
    - `width`: degrees that the picture spans; by default it just covers the field.
    - `speed`: of the drift, in deg/s, still by default; the picture is centred at time 0.
    - `direction`: of the drift, in degrees: 0 to the right, 90 upwards.

    **Raises:** `ValueError` for an image that cannot be read, and for levels that leave 0..255.
    """

    image: Float[Array, "height width"] = eqx.field(default="camera", converter=texture.read)
    level: Float[Array, ""] | None = eqx.field(default=None, converter=_level)
    contrast: Float[Array, ""] = eqx.field(default=1.0, converter=_contrast)
    width: float | None = eqx.field(
        default=None, converter=lambda width: None if width is None else _width(width), static=True
    )
    speed: Float[Array, ""] | None = eqx.field(default=None, converter=_speed)
    direction: Float[Array, ""] = eqx.field(
        default=0.0, converter=lambda direction: number("direction", direction, Degrees)
    )

    def __check_init__(self):
        texture.check_levels(self.image, self.level, self.contrast)

    @property
    def mean_level(self):
        return jnp.mean(self.image) if self.level is None else self.level

    def painter(self, eye):
        height, width = self.image.shape
        if self.width is None:
            scale = max(eye.rows / height, eye.cols / width)
        else:
            with jax.ensure_compile_time_eval():
                scale = 2 * float(eye.project(self.width / 2)) / width
        surface = texture.prepare(self.image, height * scale, width * scale, self.mean_level, self.contrast)
        right, up = (jnp.asarray(grid) for grid in eye.pixel_centres())
        if self.speed is None:
            still = surface(right, up)
            return lambda time: still
        heading = jnp.radians(self.direction)
        speed_px = self.speed * eye.pixels_per_degree

        def paint(time):
            shift = speed_px * time / 1000
            return surface(right - shift * jnp.cos(heading), up - shift * jnp.sin(heading))

        return paint


@checked
class Panorama(Background):
    """A picture painted on the inside of a globe around the eye, which may turn; it is repeated in mirror image.

    **Arguments:** as for `Photograph`, but

    - `width`: degrees of azimuth that the picture spans; 90 closes the circle without a seam.
    - `speed`: at which the scene turns about the eye, in deg/s, positive to the right; still by default.

    **Raises:** `ValueError` as for `Photograph`.
    """

    image: Float[Array, "height width"] = eqx.field(default="gravel", converter=texture.read)
    level: Float[Array, ""] | None = eqx.field(default=None, converter=_level)
    contrast: Float[Array, ""] = eqx.field(default=1.0, converter=_contrast)
    width: float = eqx.field(default=90.0, converter=_width, static=True)
    speed: Float[Array, ""] | None = eqx.field(default=None, converter=_speed)

    def __check_init__(self):
        texture.check_levels(self.image, self.level, self.contrast)

    @property
    def mean_level(self):
        return jnp.mean(self.image) if self.level is None else self.level

    def painter(self, eye):
        right, up = (jnp.asarray(grid * eye.pixels_per_degree) for grid in eye.angles())
        height, width = self.image.shape
        across = self.width * eye.pixels_per_degree
        surface = texture.prepare(self.image, across * height / width, across, self.mean_level, self.contrast)
        if self.speed is None:
            still = surface(right, up)
            return lambda time: still
        speed_px = self.speed * eye.pixels_per_degree
        return lambda time: surface(right - speed_px * time / 1000, up)


BACKGROUNDS: dict[str, type[Background]] = {"uniform": Uniform, "photograph": Photograph, "panorama": Panorama}
"""The backgrounds by the `kind` that a protocol gives."""
