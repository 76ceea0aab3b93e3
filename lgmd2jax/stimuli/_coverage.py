"""How much of each pixel a shape covers: exact areas, so that edges move continuously.

Positions are in pixels from the image's centre, right and up positive; a pixel is 1 x 1. Slopes are those of the exact
area, finite everywhere, also for a shape of size zero, off screen, or larger than the field.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

Scalar = Float[Array, ""]
Map = Float[Array, "row col"]

_THINNEST = 1e-6  # pixels; what is thinner has no stripes


def column_edges(cols: int) -> Float[Array, " edge"]:
    """Left and right borders of the columns, from left to right."""
    return jnp.arange(cols + 1) - cols / 2


def row_edges(rows: int) -> Float[Array, " edge"]:
    """Upper and lower borders of the rows, from top to bottom."""
    return rows / 2 - jnp.arange(rows + 1)


def rectangle(rows: int, cols: int, left: Scalar, right: Scalar, bottom: Scalar, top: Scalar) -> Map:
    """Share of each pixel that an upright rectangle covers: a product of two clipped intervals."""
    across = jnp.diff(jnp.clip(column_edges(cols), left, right))
    down = -jnp.diff(jnp.clip(row_edges(rows), bottom, top))
    return down[:, None] * across[None, :]


def disc(rows: int, cols: int, x: Scalar, y: Scalar, radius: Scalar) -> Map:
    """Share of each pixel that a disc covers."""
    return _disc(column_edges(cols) - x, row_edges(rows) - y, radius)


@jax.custom_jvp
def _disc(x: Float[Array, " edge_x"], y: Float[Array, " edge_y"], radius: Scalar) -> Map:
    """Area of the disc around the origin in each cell of a grid; `x` ascends, `y` descends.

    Between two column edges, the part of the disc from the axis up to y is y times the length on which the rim lies
    above y, and the cap over the rest. Differences of these are well conditioned: inside of the disc caps are zero.
    """
    above = _height(jnp.abs(y), radius)[:, None]
    cap = _past(_primitive, x, y, radius)
    x, y = x[None, :], y[:, None]
    part = y * _across(jnp.clip(x, -above, above)) + jnp.sign(y) * _across(jnp.sign(x) * cap)
    return jnp.clip(_down(part), 0, 1)


def _across(values: Float[Array, "edge_y edge_x"]) -> Float[Array, "edge_y col"]:
    """How much it grows from the left edge of a column to the right one."""
    return _convolve(values, [[-1, 1]])


def _down(values: Float[Array, "edge_y col"]) -> Map:
    """How much it grows from the lower edge of a row to the upper one."""
    return _convolve(values, [[1], [-1]])


def _convolve(values: Float[Array, "height width"], kernel: list[list[int]]) -> Float[Array, "_height _width"]:
    """A difference as a convolution, for which XLA computes the values once; for slices of them, once for each."""
    weights = jnp.array(kernel, values.dtype)[None, None]
    return jax.lax.conv(values[None, None], weights, (1, 1), "VALID", precision=jax.lax.Precision.HIGHEST)[0, 0]


@_disc.defjvp
def _disc_jvp(primals, tangents):
    """Leibniz' rule: the area changes by the length of rim or border in the cell times how fast that moves."""
    (x, y, radius), (x_dot, y_dot, radius_dot) = primals, tangents
    upright = -jnp.diff(_chord(x, y, radius), axis=0)  # (row, column edge)
    level = jnp.diff(_chord(y, x, radius), axis=0).T  # (row edge, column)
    area = jnp.diff(upright * x_dot[None, :]) - jnp.diff(level * y_dot[:, None], axis=0)
    return _disc(x, y, radius), area + _arc(x, y, radius) * radius_dot


def _chord(
    along: Float[Array, " edge"], across: Float[Array, " border"], radius: Scalar
) -> Float[Array, "border edge"]:
    """On each line `along`, the point of the disc's chord that is nearest to `across`: ends of the clipped chord."""
    half = _height(jnp.abs(along), radius)[None, :]
    return jnp.clip(across[:, None], -half, half)


def _arc(x: Float[Array, " edge_x"], y: Float[Array, " edge_y"], radius: Scalar) -> Map:
    """Length of the rim in each cell."""
    arc = radius * _past(_angle, x, y, radius)
    x, y = x[None, :], y[:, None]
    return _down(jnp.sign(y) * _across(jnp.sign(x) * arc))


def _past(
    function, x: Float[Array, " edge_x"], y: Float[Array, " edge_y"], radius: Scalar
) -> Float[Array, "edge_y edge_x"]:
    """How much a function of the rim changes from where the rim passes height |y| to |x|; 0 where |x| is nearer.

    Roots and angles are taken of edges, not of their grid: so the disc costs little more than a rectangle.
    """
    above, reach = _height(jnp.abs(y), radius), jnp.minimum(jnp.abs(x), radius)
    change = function(reach, radius)[None, :] - function(above, radius)[:, None]
    return jnp.where(reach[None, :] > above[:, None], change, 0)


def _height(x, radius):
    """Of the rim above x >= 0; 0 beyond the disc."""
    square = (radius - x) * (radius + x)
    inside = square > 0
    return jnp.where(inside, jnp.sqrt(jnp.where(inside, square, 1)), 0)


def _angle(x, radius):
    """Of the rim at x, from the top. Unlike the arc sine it bears with rounding where x nears the radius."""
    return jnp.arctan2(x, _height(x, radius))


def _primitive(x, radius):
    """Area under the rim from 0 to x."""
    return (x * _height(x, radius) + radius**2 * _angle(x, radius)) / 2


def stripes(edges: Float[Array, " edge"], low: Scalar, high: Scalar, count: int) -> Float[Array, " cell"]:
    """Mean in each cell, weighted by what [low, high] covers of it, of `count` equal stripes of +1 and -1 in turn."""
    width = jnp.maximum((high - low) / count, _THINNEST)
    position = (jnp.clip(edges, low, high) - low) / width
    # The primitive of the stripes is a triangle wave: it rises over even stripes and falls over odd ones.
    wave = 1 - jnp.abs(jnp.mod(position, 2) - 1)
    return jnp.diff(wave * width)
