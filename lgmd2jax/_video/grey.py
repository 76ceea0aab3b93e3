"""Grey levels of a picture, and their average over areas."""

import functools

import numpy as np
from jaxtyping import Float, UInt8

Picture = UInt8[np.ndarray, "row col 3"]
Grey = Float[np.ndarray, "row col"]


def grey(colours: np.ndarray) -> Grey:
    """Grey levels by ITU-R 601: .299 R + .587 G + .114 B, in the unit of the colours (row, col, 3)."""
    red, green, blue = np.moveaxis(colours.astype(np.float32), -1, 0)
    return np.float32(0.299) * red + np.float32(0.587) * green + np.float32(0.114) * blue


def area_average(levels: Grey, shape: tuple[int, int]) -> Float[np.ndarray, "height width"]:
    """The levels on a grid of another shape, each the mean over its area; interpolated where the grid is finer.

    The same rule as ffmpeg's scaler `area`.
    """
    if levels.shape == shape:
        return levels
    down, across = (_weights(old, new) for old, new in zip(levels.shape, shape, strict=True))
    return down @ levels @ across.T


@functools.lru_cache(maxsize=16)
def _weights(old: int, new: int) -> Float[np.ndarray, "new old"]:
    """How much each old pixel counts in each new one: the share that a box about the new one's centre covers of it.

    The box is as wide as a new pixel, and no narrower than an old one.
    """
    centre, half = (np.arange(new)[:, None] + 0.5) * old / new, max(old / new, 1.0) / 2
    left = np.arange(old)
    covered = np.minimum(centre + half, left + 1) - np.maximum(centre - half, left)
    weights = np.maximum(covered, 0)
    return (weights / weights.sum(axis=1, keepdims=True)).astype(np.float32)
