"""How much of each pixel a disc, a rectangle or a stripe covers: exact areas, so that edges move continuously.

Positions are in pixels from the image's centre, right and up positive; a pixel is 1 x 1. Slopes are those of the exact
area, finite everywhere, also for a shape of size zero, off screen, or larger than the field.
"""

import equinox as eqx
import jax
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

    def coverage(self) -> Map:
        """Share of each pixel."""
        return self.down[:, None] * self.across[None, :]


def stripes(edges: Float[Array, " edge"], low: Scalar, high: Scalar, count: int) -> Float[Array, " cell"]:
    """Mean in each cell, weighted by what [low, high] covers of it, of `count` equal stripes of +1 and -1 in turn."""
    width = jnp.maximum((high - low) / count, _THINNEST)
    position = (jnp.clip(edges, low, high) - low) / width
    # The primitive of the stripes is a triangle wave: it rises over even stripes and falls over odd ones.
    wave = 1 - jnp.abs(jnp.mod(position, 2) - 1)
    return jnp.diff(wave * width)


class _Lines(eqx.Module):
    """Columns or rows, as distances from the centre of a disc.

    - `border`: distances of their borders, and `side` of the centre, -1, 0 or 1, on which these are.
    - `under`: the area under the rim up to there, less half a quarter of the disc, with the sign of the side.
    - `nearest`: distances of what is nearest in each of them.
    """

    border: Float[Array, " edge"]
    side: Float[Array, " edge"]
    under: Float[Array, " edge"]
    nearest: Float[Array, " cell"]

    def __init__(self, border: Float[Array, " edge"], radius: Scalar):
        self.border, self.side = border, jnp.sign(border)
        self.under = self.side * (_under(jnp.minimum(jnp.abs(border), radius), radius) - jnp.pi / 8 * radius**2)
        self.nearest = jnp.maximum(jnp.abs((border[1:] + border[:-1]) / 2) - 0.5, 0)


class Disc(eqx.Module):
    """A disc before a grid of pixels: all that one computes before one looks at single pixels.

    Between the centre and a corner of the grid lies a rectangle. Of a corner on the disc it lies on the disc whole. Of
    any other, the area under the rim from the centre to x and that from the centre to y cover what the disc has of it,
    and a quarter of the disc besides. So roots and angles are taken of borders of columns and rows, not of their grid.
    """

    columns: _Lines
    rows: _Lines
    radius: Scalar

    def __init__(self, rows: int, cols: int, x: Scalar, y: Scalar, radius: Scalar):
        self.columns = _Lines(column_edges(cols) - x, radius)
        self.rows = _Lines(row_edges(rows) - y, radius)
        self.radius = radius

    def coverage(self) -> Map:
        """Share of each pixel: exactly 1 where all of it is on the disc, and 0 where nothing is."""
        touched = self.columns.nearest[None, :] ** 2 + self.rows.nearest[:, None] ** 2 < self.radius**2
        return jnp.where(touched, jnp.clip(1 - _of_cells(self._beyond()), 0, 1), 0)

    def _beyond(self) -> Float[Array, "edge_y edge_x"]:
        """The area beyond the rim between the centre and each corner, negative in two of the quarters."""
        x, x_side, x_under = (edges[None, :] for edges in (self.columns.border, self.columns.side, self.columns.under))
        y, y_side, y_under = (edges[:, None] for edges in (self.rows.border, self.rows.side, self.rows.under))
        return jnp.where(x**2 + y**2 > self.radius**2, x * y - y_side * x_under - x_side * y_under, 0)


def _of_cells(to_corners: Float[Array, "edge_y edge_x"]) -> Map:
    """What lies in each cell, of areas from the centre to its corners.

    A convolution, for which XLA computes each corner once; for differences of slices, once for each cell it is in.
    """
    weights = jnp.array([[-1, 1], [1, -1]], to_corners.dtype)[None, None]
    return jax.lax.conv(to_corners[None, None], weights, (1, 1), "VALID", precision=jax.lax.Precision.HIGHEST)[0, 0]


@jax.custom_jvp
def _under(x: Float[Array, " edge"], radius: Scalar) -> Float[Array, " edge"]:
    """Area under the rim from the centre to 0 <= x <= radius."""
    return (x * _height(x, radius) + radius**2 * _angle(x, radius)) / 2


@_under.defjvp
def _under_jvp(primals, tangents):
    """It grows with x by the height of the rim, and with the radius by the rim's length: slopes that are finite."""
    (x, radius), (x_dot, radius_dot) = primals, tangents
    return _under(x, radius), _height(x, radius) * x_dot + radius * _angle(x, radius) * radius_dot


def _height(x, radius):
    """Of the rim above x."""
    square = (radius - x) * (radius + x)
    inside = square > 0
    return jnp.where(inside, jnp.sqrt(jnp.where(inside, square, 1)), 0)


def _angle(x, radius):
    """Of the rim at x, from the top. On a CPU the arc tangent of XLA takes half of the time of drawing.

    The tangent of an eighth of the angle is at most tan(pi/16), for which eleven terms of the series do in any dtype.
    """
    foot = jnp.maximum(radius + _height(x, radius), jnp.finfo(x.dtype).tiny)  # a disc of no size has no angles
    tangent = x / foot  # of half the angle
    for _ in range(2):
        tangent = tangent / (1 + jnp.sqrt(1 + tangent**2))  # of half of that
    series = 0.0
    for term in reversed(range(11)):
        series = 1 / (2 * term + 1) - tangent**2 * series
    return 8 * tangent * series
