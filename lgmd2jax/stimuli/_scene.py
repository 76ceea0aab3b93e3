"""An object before a background, drawn frame by frame."""

import abc
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._eye import Eye
from lgmd2jax._types import Scalar, Times, is_concrete
from lgmd2jax.stimuli import _shapes as shapes
from lgmd2jax.stimuli._arguments import number, one_of
from lgmd2jax.stimuli._background import Background, Uniform
from lgmd2jax.stimuli._pieces import in_pieces
from lgmd2jax.stimuli._stimulus import Courses, Frames, Sketch
from lgmd2jax.stimuli._units import Degrees, GreyLevel, WeberContrast

SHAPES = ("disc", "square")

Boxes = Float[Array, "time 4"]


class Look(eqx.Module):
    """What an object looks like: grey level, now or over time, and outline; with checks, the other ones' level."""

    level: Float[Array, " *time"]
    check_level: Float[Array, " *time"]
    shape: str = eqx.field(static=True, default="square")
    checks: int = eqx.field(static=True, default=0)


def behind(background: GreyLevel | Background) -> Background:
    """The background, where a plain number stands for its grey level."""
    return background if isinstance(background, Background) else Uniform(background)


def look_from(
    background: Background,
    contrast: WeberContrast,
    level: GreyLevel | None,
    shape: str = "square",
    checks: int = 0,
    check_contrast: WeberContrast = 0.0,
    check_level: GreyLevel | None = None,
) -> Look:
    """The look of an object, from Weber contrasts or from grey levels.

    **Raises:** `ValueError` for an unknown shape, and for a level outside of 0..255.
    """
    one_of("shape", shape, SHAPES)
    if not isinstance(checks, int) or checks < 0:
        raise ValueError(f"checks is {checks!r}; give how many checks there are along a side, 0 for none")
    first = grey_level(background, "contrast", contrast, "level", level)
    if not checks:
        return Look(first, first, shape)
    second = grey_level(background, "check_contrast", check_contrast, "check_level", check_level)
    return Look(first, second, shape, checks)


def grey_level(
    background: Background, contrast_name: str, contrast: WeberContrast, level_name: str, level: GreyLevel | None
) -> Scalar:
    """The grey level of an object of a Weber contrast, or the level that is given.

    **Raises:** `ValueError` for a level outside of 0..255.
    """
    if level is not None:
        return number(level_name, level, GreyLevel, 0, 255)
    ground = background.mean_level
    result = ground * (1 + number(contrast_name, contrast, WeberContrast))
    if is_concrete(result) and not -1e-3 <= float(result) <= 255 + 1e-3:
        raise ValueError(
            f"{contrast_name} is {contrast} on a background of {float(ground):.4g}: the object would be at grey level "
            f"{float(result):.4g}; keep it in 0..255"
        )
    return result


def place(eye: Eye, azimuth: Degrees, elevation: Degrees) -> tuple[Scalar, Scalar]:
    """Pixels to the right of and above the centre; a screen without degrees has its centre alone."""
    right, up = number("azimuth", azimuth, Degrees, -89, 89), number("elevation", elevation, Degrees, -89, 89)
    if eye.degrees_per_pixel is None and is_concrete(right, up) and float(right) == float(up) == 0:
        return right, up
    return eye.project(right), eye.project(up)


class Trajectory(eqx.Module):
    """Where an object is over time."""

    @abc.abstractmethod
    def __call__(self, eye: Eye, time: Times) -> tuple[Boxes, Courses]:
        """What bounds the object: left, right, bottom, top in pixels from the centre; and courses to report."""


def boxes_around(right: Times, up: Times, half: Times) -> Boxes:
    """What bounds an object of some half-size around its centre."""
    return jnp.stack([right - half, right + half, up - half, up + half], axis=1)


def sketch_object(
    eye: Eye, time: Times, background: Background, look: Look, trajectory: Trajectory, at: Times | None = None
) -> Sketch:
    """An object on its trajectory, to be drawn with each pixel the mean over what its area sees.

    **Arguments:** `at`: the time on the trajectory in each frame, by default the frame's own.
    """
    changing, lasting = eqx.partition(look, lambda leaf: leaf.ndim == 1)
    moments = _Moments(time, time if at is None else at, changing)
    return Sketch(time, lambda: in_pieces(_draw, eye, moments, background, lasting, trajectory))


def film(eye: Eye, time: Times, background: Background) -> Frames:
    """The background alone."""
    return in_pieces(_paint, eye, time, background)


@traced_once
def _paint(eye: Eye, time: Times, background: Background) -> Frames:
    return jax.lax.map(background.painter(eye), time)


class _Moments(NamedTuple):
    """What differs from frame to frame: of a look that changes, the levels."""

    time: Times
    at: Times
    look: Look


@traced_once
def _draw(
    eye: Eye, moments: _Moments, background: Background, lasting: Look, trajectory: Trajectory
) -> tuple[Frames, Courses]:
    time, look = moments.time, eqx.combine(moments.look, lasting)
    bounds, courses = trajectory(eye, moments.at)
    paint = background.painter(eye)

    def shape(left, right, bottom, top):
        if look.shape == "disc":
            return shapes.Disc(eye.rows, eye.cols, (left + right) / 2, (bottom + top) / 2, (right - left) / 2)
        return shapes.Rectangle(eye.rows, eye.cols, left, right, bottom, top)

    def frame(now):
        time, (left, right, bottom, top), outline, level, check_level = now
        coverage = outline.coverage()
        ground = paint(time)
        mixture = ground + coverage * ((level + check_level) / 2 - ground)
        if look.checks:
            across = shapes.stripes(shapes.column_edges(eye.cols), left, right, look.checks)
            down = shapes.stripes(-shapes.row_edges(eye.rows), -top, -bottom, look.checks)
            checks = down[:, None] * across[None, :]
            # Stripes are weighted by what the bounding box covers: all of a square, too much of a disc.
            checks = checks * coverage if look.shape == "disc" else checks
            mixture = mixture + checks * (level - check_level) / 2
        return mixture

    levels = (jnp.broadcast_to(each, time.shape) for each in (look.level, look.check_level))
    # Of all frames at once: within a frame XLA would compute parts of it anew for each pixel.
    sides = tuple(bounds.T)
    return jax.lax.map(frame, (time, sides, jax.vmap(shape)(*sides), *levels)), courses
