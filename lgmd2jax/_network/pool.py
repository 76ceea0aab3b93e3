"""Sums over the whole field, for eqs 11 and 13."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._network.retina import Map


def pool(x: Map, weight: float = 1.0) -> Float[Array, ""]:
    """The sum of weight x.

    It is written as products with constant vectors, since a plain sum is a chain of scalar additions on a CPU and costs
    as much as the rest of a frame. With the weight inside, nothing is left that a single step would fuse into the cell
    and a scan would not, so that both round alike. Along rows first: the other order makes a batch transpose its maps.
    """
    rows, cols = x.shape
    left, right = jnp.full(rows, weight, x.dtype), jnp.ones(cols, x.dtype)
    return jnp.dot(left, jnp.dot(x, right, precision="highest"), precision="highest")
