"""Types that every room shares, and what JAX knows of a value."""

from typing import TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Float, Real

Scalar = Float[Array, ""]
Map = Float[Array, "row col"]
Times = Float[Array, " time"]
Number = float | int | np.number | Real[Array | np.ndarray, ""]

Tree = TypeVar("Tree")


def is_concrete(*values) -> bool:
    """Whether all values can be looked at: arrays or numbers, and not what stands for them while JAX traces."""
    return all(isinstance(value, (int, float, np.generic, np.ndarray, jax.Array)) for value in values) and not any(
        isinstance(value, Tracer) for value in values
    )


def cast(tree: Tree, dtype) -> Tree:
    """All leaves in this dtype."""
    return jax.tree.map(lambda leaf: leaf.astype(dtype), tree)


def unless_nan(source: Float[Array, " *map"], value: Float[Array, " *map"]) -> Float[Array, " *map"]:
    """The value, and NaN where its source is: a comparison, or XLA's product with one, would hide that."""
    return jnp.where(jnp.isnan(source), jnp.nan, value)
