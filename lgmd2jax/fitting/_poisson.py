"""The likelihood of spike counts: an inhomogeneous Poisson process around the predicted rate.

Minus twice the log likelihood is, up to what the counts alone decide, the sum of squares of the deviance residuals, so
that least squares of these is maximum likelihood. Near the truth their expected curvature is Fisher's information, that
of Pearson's residuals (mu - n)/sqrt(mu), which are taken for errors and for the goodness of fit.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float
from scipy.special import gammaln

LEAST_RATE = 1e-3  # spikes/s that a predicted rate counts as at least: a spike where none can be is no proof
_NEAR = 1e-2  # relative difference of count and mean below which a series is more exact than the logarithm
_TERMS = (1.0, -2 / 3, 1 / 2, -2 / 5, 1 / 3, -2 / 7, 1 / 4)  # of 2 (x - log(1 + x)) / x^2


def deviance_residuals(counts: Float[Array, "*n"], means: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """sign(mu - n) sqrt(2 (mu - n - n log(mu/n))), with slopes that are right also at mu = n; means are above 0."""
    some = counts > 0
    safe = jnp.where(some, counts, 1.0)
    x = (jnp.where(some, means, 1.0) - safe) / safe
    near = jnp.abs(x) < _NEAR
    far = jnp.where(near, 1.0, x)
    close = jnp.where(near, x, 0.0)
    ratio = sum(term * close**power for power, term in enumerate(_TERMS))
    shape = jnp.where(near, close * jnp.sqrt(ratio), jnp.sign(far) * jnp.sqrt(2 * (far - jnp.log1p(far))))
    return jnp.where(some, jnp.sqrt(safe) * shape, jnp.sqrt(2 * jnp.where(some, 1.0, means)))


def bin_means(rate: Float[Array, "time *rest"], counted: Bool[Array, " time"]) -> Float[Array, "time *rest"]:
    """The mean of a rate over bins that reach half-way to the neighbouring frames, between which it is linear.

    The expected count of a process is the integral of its rate, which lies below the rate in the middle wherever this
    has a peak. Beyond the frames that are counted the rate stays as it is.
    """

    def rise(towards: slice, edge: tuple[int, int]) -> Float[Array, "time *rest"]:
        beside = jnp.pad(rate[towards], (edge, *((0, 0),) * (rate.ndim - 1)))
        known = jnp.pad(counted[towards], edge).reshape(-1, *(1,) * (rate.ndim - 1))
        return jnp.where(known, beside - rate, 0)

    return rate + (rise(slice(None, -1), (1, 0)) + rise(slice(1, None), (0, 1))) / 8


def minus_two_log_likelihood(counts: Float[np.ndarray, "*n"], means: Float[np.ndarray, "*n"]) -> float:
    """-2 ln L of independent Poisson counts, all terms included."""
    return float(2 * np.sum(means - counts * np.log(means) + gammaln(counts + 1)))
