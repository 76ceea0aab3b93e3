"""Facts of sampled curves: peaks between samples, straight lines, stretches. For NumPy and for JAX."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float


def vertex(before, at, after) -> Array:
    """Where the parabola through a peak and its neighbours is highest, in samples from the peak: -1/2 to 1/2."""
    bend = before - 2 * at + after
    place = 0.5 * (before - after) / jnp.where(bend < 0, bend, -1)
    return jnp.where(bend < 0, jnp.clip(place, -0.5, 0.5), 0)


def peak_times(
    time: Float[np.ndarray, " time"], curves: Float[np.ndarray, "curve time"]
) -> Float[np.ndarray, " curve"]:
    """When each curve is highest: the vertex of the parabola through its largest value and the neighbours of that."""
    place = np.clip(curves.argmax(axis=1), 1, len(time) - 2)
    rows = np.arange(len(curves))
    beyond = np.asarray(vertex(*(curves[rows, place + side] for side in (-1, 0, 1))))
    return time[place] + beyond * (time[1] - time[0])


def line_through(y: Float[Array | np.ndarray, " place"], x: Float[np.ndarray, " place"]) -> tuple[Any, Any, Any]:
    """Slope, intercept and residuals of the straight line by least squares."""
    centred = x - x.mean()
    slope = (y * centred).sum() / (centred**2).sum()
    intercept = y.mean() - slope * x.mean()
    return slope, intercept, y - slope * x - intercept


def stretches(on: Bool[np.ndarray, " time"]) -> list[tuple[int, int]]:
    """First and last place of every run of truth."""
    edges = np.flatnonzero(np.diff(on.astype(int), prepend=0, append=0))
    return [(int(start), int(after) - 1) for start, after in zip(edges[::2], edges[1::2], strict=True)]
