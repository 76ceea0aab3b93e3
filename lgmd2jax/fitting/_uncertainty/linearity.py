"""Do linearised errors hold? Chi2 two standard errors away, against what the linearisation says of it."""

import itertools
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax.fitting._uncertainty.covariance import Uncertainty
from lgmd2jax.fitting._uncertainty.profile import refitted

_AWAY = 2.0  # standard errors
_FACTOR = 1.5  # by which chi2 may rise more, or less, than it should
_PLACES = np.linspace(0, 1, 5)  # of the box, where a parameter that bends is put to see what follows it
_AS_GOOD = 3.84  # rise of chi2 within which a place is as good, at 95 %
_BEYOND = 0.5  # standard errors by which another parameter may move meanwhile, beyond what its covariance says
_STEPS = 20
_NOTHING = -1  # in place of a parameter's index, where none is held
_ROUNDING = 1e-7  # of the box: standard errors so small are those of a twin without noise, and nothing bends within


def curved(
    residuals: Callable[[Float[Array, " free"]], Float[Array, " n"]], z: Float[np.ndarray, " free"], u: Uncertainty
) -> tuple[str, ...]:
    """The parameters whose intervals by linearisation cannot be trusted: curves bend within them, or they hang on such.

    Each is moved to both sides, and the others with it as their correlations say: were the curves linear, chi2 would
    rise by the square of the standard errors, beside its slope, where the best point is not quite the optimum. Those
    that bend, stand at a bound or are not determined are then put to places all over their range, where the others are
    fitted anew: what moves there further than its standard error says, while the curves fit as well, is rough too.

    **Arguments:** `residuals` by a point of the unit box, correlated ones already counted as fractions; `z` the best
    point, `u` its uncertainty.
    """
    errors = np.sqrt(np.diag(u.covariance_z))
    judged = u.determined & (errors > _ROUNDING)
    if not judged.any():
        return ()
    rough = judged.copy()
    rough[judged] = _bends(residuals, z, u, errors, np.flatnonzero(judged))
    loose = rough | ~u.determined | (u.on_bound != 0)
    if loose.any() and not rough[judged].all():
        rough |= judged & _follows(residuals, z, u, errors, np.flatnonzero(loose))
    return tuple(name for name, it in zip(u.names, rough, strict=True) if it)


def _bends(residuals, z, u: Uncertainty, errors, judged) -> np.ndarray:
    """Of the judged ones, within two of whose standard errors chi2 is not that of linear curves."""
    ways = _AWAY * u.covariance_z[judged] / errors[judged, None]
    points = np.clip(z + np.concatenate([ways, -ways]), 0, 1)
    chi2 = np.asarray(_chi2(residuals, jnp.asarray(np.vstack([z, points]))))
    rise = (chi2[1:] - chi2[0]) / u.variance - (points - z) @ u.gradient
    expected = np.einsum("pi,ij,pj->p", points - z, u.information, points - z)
    cut = expected < 1  # by a wall of the box: little is left of the way
    bends = ~cut & ((rise > _FACTOR * expected) | (rise < expected / _FACTOR))
    return bends.reshape(2, -1).any(axis=0)


def _follows(residuals, z, u: Uncertainty, errors, loose) -> np.ndarray:
    """Which parameters move with one that is loose, along its valley or into the next."""
    indices, places = zip((_NOTHING, 0.0), *itertools.product(loose, _PLACES), strict=True)
    points, chi2 = _refits(residuals, jnp.asarray(z), jnp.asarray(indices), jnp.asarray(places))
    (best, *points), (least, *chi2) = np.asarray(points), np.asarray(chi2)
    rise = np.maximum((np.array(chi2) - least) / u.variance, 0)[:, None]
    # Of linear curves, no parameter moves by more than the root of the rise, in its standard errors.
    beyond = np.abs(np.array(points) - best) > (np.sqrt(rise) + _BEYOND) * errors
    return (beyond & (rise < _AS_GOOD)).any(axis=0)


@eqx.filter_jit
def _chi2(residuals, points: Float[Array, "points free"]) -> Float[Array, " points"]:
    return jax.lax.map(lambda z: jnp.square(residuals(z)).sum(), points)


@eqx.filter_jit
def _refits(residuals, z, indices, places):
    return jax.lax.map(lambda it: refitted(residuals, z, it[0], it[1], _STEPS), (indices, places))
