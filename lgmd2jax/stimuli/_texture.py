"""Pictures as surfaces that have a grey level anywhere, also between their pixels."""

import functools
import os
import pathlib
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._types import Map, is_concrete
from lgmd2jax._words import nearest, warn

PHOTOGRAPHS = {
    "astronaut": "astronaut.png",
    "brick": "brick.png",
    "camera": "camera.png",
    "chelsea": "chelsea.png",
    "coffee": "coffee.png",
    "coins": "coins.png",
    "grass": "grass.png",
    "gravel": "gravel.png",
    "motorcycle": "motorcycle_left.png",
    "rocket": "rocket.jpg",
}
"""The pictures that scikit-image's wheel carries, by the names that a background takes; nothing is downloaded."""
_TEXELS = 2  # for each pixel of the eye, so that interpolation between them hardly blurs


def read(image) -> Float[Array, "height width"]:
    """Grey levels 0..255 of a photograph by name, of an image by path, or of an array.

    **Raises:** `ValueError` for an image that cannot be read or is no picture.
    """
    if isinstance(image, (str, os.PathLike)):
        image = _load(os.fspath(image))
    if np.ndim(image) != 2 or min(np.shape(image)) < 2:
        raise ValueError(f"image has shape {np.shape(image)}; give grey levels as (row, col)")
    if is_concrete(image) and not (np.all(np.isfinite(image)) and np.min(image) >= 0 and np.max(image) <= 255):
        raise ValueError("image holds values outside of 0..255; give grey levels")
    if is_concrete(image) and 0 < np.max(image) <= 1:
        warn("image holds no grey level above 1; was 0..255 meant, given in 0..1?")
    return jnp.asarray(image, dtype=float)


@functools.lru_cache(maxsize=16)
def _load(name: str) -> np.ndarray:
    # Here, since most stimuli have no photograph and these take long to load.
    import imageio.v3 as iio
    import skimage
    from skimage.color import rgb2gray
    from skimage.util import img_as_float

    if name in PHOTOGRAPHS:
        path = pathlib.Path(skimage.__file__).parent / "data" / PHOTOGRAPHS[name]
    elif not (path := pathlib.Path(name).expanduser()).is_file():
        raise ValueError(f"image is {name!r}, neither a file nor a photograph; choose {nearest(name, PHOTOGRAPHS)}")
    try:
        picture = iio.imread(path, plugin="pillow")
    except (OSError, ValueError, SyntaxError) as error:
        raise ValueError(f"image {name!r} cannot be read: {error}") from error
    grey = rgb2gray(picture[..., :3]) if picture.ndim == 3 else img_as_float(picture)
    return 255 * grey


def check_levels(image, mean_level, contrast) -> None:
    """Refuse a mean level and a contrast that take a picture out of 0..255."""
    if not is_concrete(image, contrast) or not (mean_level is None or is_concrete(mean_level)):
        return
    own = float(np.mean(image))
    mean_level = own if mean_level is None else float(mean_level)
    low, high = (mean_level * (1 + float(contrast) * (float(end(image)) / own - 1)) for end in (np.min, np.max))
    if low < -1e-3 or high > 255 + 1e-3:
        raise ValueError(
            f"level {mean_level:.4g} with contrast {float(contrast):.4g} takes the picture to {low:.4g}..{high:.4g}; "
            "lower the contrast, or choose a level that keeps it in 0..255"
        )


def prepare(
    image: Float[Array, "height width"], height_px: float, width_px: float, mean_level, contrast
) -> Callable[[Map, Map], Map]:
    """A function that gives grey levels at places right of and above the picture's centre, in pixels of the eye.

    The picture is reduced once, without aliasing, to what a pixel sees; places between are interpolated linearly, and
    beyond its borders it goes on in mirror image.
    """
    image = mean_level * (1 + contrast * (image / jnp.mean(image) - 1))
    shape = max(2, round(height_px * _TEXELS)), max(2, round(width_px * _TEXELS))
    texels = _smooth(_smooth(jax.image.resize(image, shape, "linear", antialias=True)).T).T
    tile = jnp.concatenate([texels, texels[::-1]])
    tile = jnp.concatenate([tile, tile[:, ::-1]], axis=1)

    def at(right: Map, up: Map) -> Map:
        row = (0.5 - up / height_px) * shape[0] - 0.5
        col = (0.5 + right / width_px) * shape[1] - 0.5
        return _interpolate(tile, row, col)

    return at


def _smooth(texels):
    """Mean over the width of a pixel of the eye, down the columns."""
    padded = jnp.pad(texels, ((1, 1), (0, 0)), mode="edge")
    return (padded[:-2] + 2 * padded[1:-1] + padded[2:]) / 4


def _interpolate(tile: Float[Array, "height width"], row: Map, col: Map) -> Map:
    """Between the four nearest texels of a tile that repeats for ever."""
    above, left = jnp.floor(row), jnp.floor(col)
    down, across = row - above, col - left
    i, j = above.astype(int), left.astype(int)
    rows, cols = tile.shape

    def texel(di, dj):
        return tile[(i + di) % rows, (j + dj) % cols]

    upper = (1 - across) * texel(0, 0) + across * texel(0, 1)
    lower = (1 - across) * texel(1, 0) + across * texel(1, 1)
    return (1 - down) * upper + down * lower
