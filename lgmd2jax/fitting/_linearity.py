"""Do linearised errors hold? Chi2 two standard errors away, against what the linearisation says of it."""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax.fitting._uncertainty import Uncertainty

_AWAY = 2.0  # standard errors
_FACTOR = 1.5  # by which chi2 may rise more, or less, than it should
_ROUNDING = 1e-7  # of the box: standard errors so small are those of a twin without noise, and nothing bends within


def curved(
    residuals: Callable[[Float[Array, " free"]], Float[Array, " n"]], z: Float[np.ndarray, " free"], u: Uncertainty
) -> tuple[str, ...]:
    """The parameters whose intervals by linearisation cannot be trusted, since the curves bend within them.

    Each is moved to both sides, and the others with it as their correlations say: were the curves linear, chi2 would
    rise by the square of the standard errors, beside its slope, where the best point is not quite the optimum.

    **Arguments:** `residuals` by a point of the unit box, correlated ones already counted as fractions; `z` the best
    point, `u` its uncertainty.
    """
    errors = np.sqrt(np.diag(u.covariance_z))
    judged = np.flatnonzero(u.determined & (errors > _ROUNDING))
    if not judged.size:
        return ()
    ways = _AWAY * u.covariance_z[judged] / errors[judged, None]
    points = np.clip(z + np.concatenate([ways, -ways]), 0, 1)
    chi2 = np.asarray(_chi2(residuals, jnp.asarray(np.vstack([z, points]))))
    rise = (chi2[1:] - chi2[0]) / u.variance - (points - z) @ u.gradient
    expected = np.einsum("pi,ij,pj->p", points - z, u.information, points - z)
    cut = expected < 1  # by a wall of the box: little is left of the way
    bends = ~cut & ((rise > _FACTOR * expected) | (rise < expected / _FACTOR))
    return tuple(u.names[i] for i in judged[bends.reshape(2, -1).any(axis=0)])


@eqx.filter_jit
def _chi2(residuals, points: Float[Array, "points free"]) -> Float[Array, " points"]:
    return jax.lax.map(lambda z: jnp.square(residuals(z)).sum(), points)
