"""An object before a background, drawn frame by frame."""

import abc

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, ScalarLike

from lgmd2jax._eye import Eye
from lgmd2jax._types import Times, is_concrete
from lgmd2jax.stimuli import _coverage as coverage
from lgmd2jax.stimuli._arguments import number, one_of
from lgmd2jax.stimuli._background import Background, Uniform
from lgmd2jax.stimuli._disc import Disc
from lgmd2jax.stimuli._stimulus import Stimulus

SHAPES = ("disc", "square")

Boxes = Float[Array, "time 4"]


class Look(eqx.Module):
    """What an object looks like: grey level, now or over time, and outline; with checks, the other ones' level."""

    level: Float[Array, " *time"]
    check_level: Float[Array, " *time"]
    shape: str = eqx.field(static=True, default="square")
    checks: int = eqx.field(static=True, default=0)


def behind(background: ScalarLike | Background) -> Background:
    """The background, where a plain number stands for its grey level."""
    return background if isinstance(background, Background) else Uniform(background)


def look(
    background: Background,
    contrast: ScalarLike,
    level: ScalarLike | None,
    shape: str = "square",
    checks: int = 0,
    check_contrast: ScalarLike = 0.0,
    check_level: ScalarLike | None = None,
) -> Look:
    """The look of an object, from Weber contrasts or from grey levels.

    **Raises:** `ValueError` for an unknown shape, and for a level outside of 0..255.
    """
    one_of("shape", shape, SHAPES)
    if not isinstance(checks, int) or checks < 0:
        raise ValueError(f"checks is {checks!r}; give how many checks there are along a side, 0 for none")
    first = grey(background, "contrast", contrast, "level", level)
    if not checks:
        return Look(first, first, shape)
    return Look(first, grey(background, "check_contrast", check_contrast, "check_level", check_level), shape, checks)


def grey(background: Background, contrast_name: str, contrast: ScalarLike, level_name: str, level: ScalarLike | None):
    """The grey level of an object of a Weber contrast, or the level that is given."""
    if level is not None:
        return number(level_name, level, "grey levels", 0, 255)
    ground = background.mean_level
    result = ground * (1 + number(contrast_name, contrast, "(Weber)"))
    if is_concrete(result) and not -1e-3 <= float(result) <= 255 + 1e-3:
        raise ValueError(
            f"{contrast_name} is {contrast} on a background of {float(ground):.4g}: the object would be at grey level "
            f"{float(result):.4g}; keep it in 0..255"
        )
    return result


def place(eye: Eye, azimuth: ScalarLike, elevation: ScalarLike) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Pixels to the right of and above the centre; a screen without degrees has its centre alone."""
    right, up = number("azimuth", azimuth, "degrees", -89, 89), number("elevation", elevation, "degrees", -89, 89)
    if eye.degrees_per_pixel is None and is_concrete(right, up) and float(right) == float(up) == 0:
        return right, up
    return eye.project(right), eye.project(up)


class Path(eqx.Module):
    """Where an object is over time."""

    @abc.abstractmethod
    def __call__(self, eye: Eye, time: Times) -> tuple[Boxes, dict[str, Times]]:
        """What bounds the object: left, right, bottom, top in pixels from the centre; and courses to report."""


def boxes(right: Times, up: Times, half: Times) -> Boxes:
    """What bounds an object of some half-size around its centre."""
    return jnp.stack([right - half, right + half, up - half, up + half], axis=1)


def show(eye: Eye, time: Times, background: Background, look: Look, path: Path) -> Stimulus:
    """A stimulus of an object on its path: each pixel the mean over what its area sees."""
    frames, courses = _draw(eye, time, background, look, path)
    return Stimulus(frames, eye.fps, time, courses=courses)


@eqx.filter_jit
def film(eye: Eye, time: Times, background: Background) -> Float[Array, "time row col"]:
    """The background alone."""
    return jax.lax.map(background.painter(eye), time)


@eqx.filter_jit
def _draw(
    eye: Eye, time: Times, background: Background, look: Look, path: Path
) -> tuple[Float[Array, "time row col"], dict[str, Times]]:
    bounds, courses = path(eye, time)
    paint = background.painter(eye)

    def shape(left, right, bottom, top):
        if look.shape == "disc":
            return Disc(eye.rows, eye.cols, (left + right) / 2, (bottom + top) / 2, (right - left) / 2)
        return coverage.Rectangle(eye.rows, eye.cols, left, right, bottom, top)

    def frame(now):
        time, (left, right, bottom, top), outline, level, check_level = now
        covered = outline.covered()
        ground = paint(time)
        seen = ground + covered * ((level + check_level) / 2 - ground)
        if look.checks:
            across = coverage.stripes(coverage.column_edges(eye.cols), left, right, look.checks)
            down = coverage.stripes(-coverage.row_edges(eye.rows), -top, -bottom, look.checks)
            checks = down[:, None] * across[None, :]
            # Stripes are weighted by what the bounding box covers: all of a square, too much of a disc.
            checks = checks * covered if look.shape == "disc" else checks
            seen = seen + checks * (level - check_level) / 2
        return seen

    levels = (jnp.broadcast_to(each, time.shape) for each in (look.level, look.check_level))
    # Of all frames at once: within a frame XLA would compute parts of it anew for each pixel.
    sides = tuple(bounds.T)
    return jax.lax.map(frame, (time, sides, jax.vmap(shape)(*sides), *levels)), courses
