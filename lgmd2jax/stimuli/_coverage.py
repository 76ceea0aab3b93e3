"""How much of each pixel a shape covers: exact areas, so that edges move continuously.

Positions are in pixels from the image's centre, right and up positive; a pixel is 1 x 1. Slopes are those of the exact
area, finite everywhere, also for a shape of size zero, off screen, or larger than the field.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._types import Map, Scalar

_THINNEST = 1e-6  # pixels; what is thinner has no stripes


def column_edges(cols: int) -> Float[Array, " edge"]:
    """Left and right borders of the columns, from left to right."""
    return jnp.arange(cols + 1) - cols / 2


def row_edges(rows: int) -> Float[Array, " edge"]:
    """Upper and lower borders of the rows, from top to bottom."""
    return rows / 2 - jnp.arange(rows + 1)


class Rectangle(eqx.Module):
    """An upright rectangle before a grid of pixels: what it covers of each column and of each row."""

    across: Float[Array, " col"]
    down: Float[Array, " row"]

    def __init__(self, rows: int, cols: int, left: Scalar, right: Scalar, bottom: Scalar, top: Scalar):
        self.across = jnp.diff(jnp.clip(column_edges(cols), left, right))
        self.down = -jnp.diff(jnp.clip(row_edges(rows), bottom, top))

    def covered(self) -> Map:
        """Share of each pixel."""
        return self.down[:, None] * self.across[None, :]


def stripes(edges: Float[Array, " edge"], low: Scalar, high: Scalar, count: int) -> Float[Array, " cell"]:
    """Mean in each cell, weighted by what [low, high] covers of it, of `count` equal stripes of +1 and -1 in turn."""
    width = jnp.maximum((high - low) / count, _THINNEST)
    position = (jnp.clip(edges, low, high) - low) / width
    # The primitive of the stripes is a triangle wave: it rises over even stripes and falls over odd ones.
    wave = 1 - jnp.abs(jnp.mod(position, 2) - 1)
    return jnp.diff(wave * width)
