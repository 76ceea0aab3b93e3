"""Largest and least values that keep NaN: XLA's maxima and minima lose it where they run over a batch on a CPU."""

import jax.numpy as jnp
from jaxtyping import Array, Float


def largest(values: Float[Array, "..."], axis: int | None = None) -> Float[Array, "..."]:
    """The maximum; NaN where any of the values is."""
    return jnp.where(jnp.any(jnp.isnan(values), axis), jnp.nan, jnp.max(values, axis))


def least(values: Float[Array, "..."], axis: int | None = None) -> Float[Array, "..."]:
    """The minimum; NaN where any of the values is."""
    return -largest(-values, axis)
