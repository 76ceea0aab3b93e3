"""Losses that outliers cannot pull far, as a change of the residuals, so that least squares stays least squares."""

from typing import Literal, get_args

import jax.numpy as jnp
from jaxtyping import Array, Float

Loss = Literal["squares", "huber", "soft_l1", "cauchy"]
LOSSES = get_args(Loss)


def robust(residuals: Float[Array, "*n"], loss: Loss) -> Float[Array, "*n"]:
    """Residuals whose squares are rho(r^2), with rho as in `scipy.optimize.least_squares`; outliers begin at 1.

    A residual counts standard errors, so that 1 is one of them; weight the targets for another limit.
    """
    if loss == "squares":
        return residuals
    square = jnp.square(residuals)
    if loss == "soft_l1":
        return residuals * jnp.sqrt(2 / (1 + jnp.sqrt(1 + square)))
    large = square > (1 if loss == "huber" else 1e-8)
    # The branch that is not taken must have a finite slope too.
    square = jnp.where(large, square, 1.0)
    ratio = (2 * jnp.sqrt(square) - 1) / square if loss == "huber" else jnp.log1p(square) / square
    return residuals * jnp.where(large, jnp.sqrt(ratio), 1.0)
