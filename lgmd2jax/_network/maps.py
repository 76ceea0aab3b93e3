"""What lies beyond the border: the edge of a map, repeated by one pixel all around (the convolutions of eqs 5, 6, 10).

What a pixel remembers depends on that pixel alone. So an edge that is repeated around P stays repeated around all that
follows from P, and whoever wants neighbours finds them by slices.
"""

import functools
import operator

import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._types import Map

Bordered = Float[Array, "row_and_border col_and_border"]
Row = Float[Array, " col"]


def bordered(x: Map) -> Bordered:
    """The map with its edge repeated around it."""
    return jnp.pad(x, 1, mode="edge")


def bordered_onto(onto: Bordered, x: Map, above: Row, below: Row) -> Bordered:
    """The map between two rows, with its edge repeated to the left and the right.

    Corners apart: rows that are padded would be written a pixel at a time.

    **Arguments:** `onto`: a map of that size which is no longer needed. In a scan it is written over where it lies,
    where a pad on a CPU would copy the map twice.
    """
    onto = onto.at[1:-1, 1:-1].set(x).at[0, 1:-1].set(above).at[-1, 1:-1].set(below)
    for end in (0, -1):
        onto = onto.at[1:-1, end].set(x[:, end]).at[0, end].set(above[end]).at[-1, end].set(below[end])
    return onto


def inside(x: Bordered) -> Map:
    """The map without its border."""
    return x[1:-1, 1:-1]


def folded(x: Map) -> Float[Array, "part_of_row col"]:
    """Every four neighbouring rows added to one, or fewer that divide all, for the sum of a map that is made here.

    On a CPU it is then added up while it is made: neighbouring rows share what they read, and little of it is written
    and read again. Where a pixel takes many maps to make, this does not pay.
    """
    count = next(count for count in (4, 3, 2, 1) if len(x) % count == 0)
    return functools.reduce(operator.add, [x[first::count] for first in range(count)])


def pool(x: Map, weight: float = 1.0) -> Float[Array, ""]:
    """The sum of weight x.

    It is written as products with constant vectors, since a plain sum is a chain of scalar additions on a CPU and costs
    as much as the rest of a frame. With the weight inside, nothing is left that a single step would fuse into the cell
    and a scan would not, so that both round alike. Along rows first: the other order makes a batch transpose its maps.
    """
    rows, cols = x.shape
    left, right = jnp.full(rows, weight, x.dtype), jnp.ones(cols, x.dtype)
    return jnp.dot(left, jnp.dot(x, right, precision="highest"), precision="highest")
