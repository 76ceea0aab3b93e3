"""The first-order low-pass dX/dt = (Y - X)/tau in discrete time, for eqs 4 and 14."""

from typing import Literal, get_args

import jax.numpy as jnp
from jaxtyping import Array, Float

LowPass = Literal["backward_euler", "exact"]
LOW_PASS_FORMS = get_args(LowPass)
_INSTANT = 1e-6  # ms, after which nothing is left of the past at any frame rate


def coefficient(tau: Float[Array, ""], interval: Float[Array, ""], form: LowPass) -> Float[Array, ""]:
    """The a of X(t) = X(t-1) + a (Y(t) - X(t-1)).

    `"backward_euler"` is ti/(ti + tau), as in the authors' code; `"exact"` is 1 - exp(-ti/tau), the solution for an
    input that stays constant within a frame.

    **Arguments:** `tau` and `interval` (ti) in ms.
    """
    if form == "exact":
        return -jnp.expm1(-interval / jnp.maximum(tau, _INSTANT))  # whose slope is finite where tau is 0
    return interval / (interval + tau)


def low_pass(x: Float[Array, " *map"], y: Float[Array, " *map"], a: Float[Array, ""]) -> Float[Array, " *map"]:
    """One frame of the filter: X(t) from X(t-1) and Y(t)."""
    return x + a * (y - x)
