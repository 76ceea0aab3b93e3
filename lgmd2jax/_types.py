"""Types that every room shares, and what JAX knows of a value."""

from typing import TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Float, PRNGKeyArray, Real, ScalarLike, UInt32
from typing_extensions import TypeAliasType

Scalar = Float[Array, ""]
Map = Float[Array, "row col"]
Times = Float[Array, " time"]
# By names of their own, which `help` shows in the place of what they stand for.
Key = TypeAliasType("Key", PRNGKeyArray | UInt32[Array, "2"])
Number = TypeAliasType("Number", float | int | np.number | Real[Array | np.ndarray, ""])

Tree = TypeVar("Tree")


def is_concrete(*values) -> bool:
    """Whether all values can be looked at: arrays or numbers, and not what stands for them while JAX traces."""
    return all(isinstance(value, (int, float, np.generic, np.ndarray, jax.Array)) for value in values) and not any(
        isinstance(value, Tracer) for value in values
    )


def strong(number: ScalarLike) -> Scalar:
    """A float as an array of JAX's, put there: from `jnp.asarray` comes a program that is compiled."""
    return jax.device_put(np.asarray(number, float))


def cast(tree: Tree, dtype) -> Tree:
    """All leaves in this dtype."""
    return jax.tree.map(lambda leaf: leaf.astype(dtype), tree)


def unless_nan(source: Float[Array, " *map"], value: Float[Array, " *map"]) -> Float[Array, " *map"]:
    """The value, and NaN where its source is: a comparison, or XLA's product with one, would hide that."""
    return jnp.where(jnp.isnan(source), jnp.nan, value)


def check_key(key: Key) -> None:
    """Raise `ValueError` for what is no single key of JAX's, such as a seed or a generator of NumPy's."""
    is_array = isinstance(key, jax.Array)
    if is_array and jnp.issubdtype(key.dtype, jax.dtypes.prng_key) and key.shape == ():
        return
    if not (is_array and key.dtype == jnp.uint32 and key.shape == (2,)):
        raise ValueError(f"key is {key!r:.60}; give one of JAX's, such as jax.random.key(0)")
