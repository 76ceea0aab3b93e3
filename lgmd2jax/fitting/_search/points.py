"""Random points of the unit box, decided by a key."""

import jax
import numpy as np
import scipy
from jaxtyping import Array, Float

from lgmd2jax.fitting._search.space import Space


def seed_of(key: Array) -> tuple[int, ...]:
    """A key as the whole numbers that seed NumPy and SciPy."""
    return tuple(int(word) for word in np.ravel(jax.random.key_data(key)))


def sobol(dimensions: int, count: int, seed: tuple[int, ...]) -> Float[np.ndarray, "count dimensions"]:
    """Points that fill the unit box evenly; another seed gives other points. Without dimensions there is one point."""
    if dimensions == 0:
        return np.zeros((1, 0))
    sampler = scipy.stats.qmc.Sobol(dimensions, scramble=True, rng=np.random.default_rng(list(seed)))
    return sampler.random_base2(max(count - 1, 1).bit_length())[:count]


def starting_points(
    space: Space, start: Float[np.ndarray, " free"], count: int, seed: tuple[int, ...]
) -> Float[np.ndarray, "count free"]:
    """The start, then points that differ from it in the parameters that the pixels need."""
    points = np.repeat(start[None], count, axis=0)
    pixels = list(space.pixel_indices)
    if pixels:
        points[1:, pixels] = sobol(len(pixels), count, seed)[: count - 1]
    return points
