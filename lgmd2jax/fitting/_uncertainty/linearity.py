"""Do linearised errors hold? Chi2 two standard errors away, against what the linearisation says of it."""

import itertools
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax.fitting._uncertainty.covariance import Uncertainty
from lgmd2jax.fitting._uncertainty.profile import refit

Residuals = Callable[[Float[Array, " free"]], Float[Array, " n"]]

_AWAY = 2.0  # standard errors at which chi2 is compared
_FACTOR = 1.5  # by which chi2 may rise more, or less, than linear curves make it rise
_PLACES = np.linspace(0, 1, 5)  # of the box, at which a loose parameter is held while the others are fitted anew
_AS_GOOD = 3.84  # rise of chi2 up to which a place fits as well, at 95 %
_BEYOND = 0.5  # standard errors that another parameter may move further than its covariance says
_STEPS = 20
_NOTHING = -1  # in place of a parameter's index: none is held
_ROUNDING = 1e-7  # of the box: standard errors so small are those of a twin without noise, and nothing bends within


def nonlinear_parameters(residuals: Residuals, z: Float[np.ndarray, " free"], u: Uncertainty) -> tuple[str, ...]:
    """The parameters whose intervals by linearisation cannot be trusted. A parameter is one of them for any of these:

    - The curves are nonlinear within its interval. It is moved by two standard errors to both sides, and the others
      with it by their correlations. Linear curves make chi2 rise by the square of the number of standard errors, plus
      its slope if the best point is not quite the optimum. Here chi2 rises much more, or much less.
    - The point is no optimum: the fit was stopped, or chose a model for what else it does. That goes for all of them.
    - It depends on a loose parameter, which is one that bends, stands at a bound or is not determined. The loose
      parameter is held at places all over its range, and the others are fitted anew. At a place that fits as well, this
      parameter has moved much further than its standard error allows.

    **Arguments:** `residuals` by a point of the unit box, correlated ones already counted as fractions; `z` the best
    point, `u` its uncertainty.
    """
    errors = np.sqrt(np.diag(u.covariance_z))
    judged = u.determined & (errors > _ROUNDING)
    if not judged.any():
        return ()
    if _fall(u) > _AS_GOOD:
        return tuple(name for name, is_judged in zip(u.names, judged, strict=True) if is_judged)
    nonlinear = judged.copy()
    nonlinear[judged] = _bend(residuals, z, u, errors, np.flatnonzero(judged))
    loose = nonlinear | ~u.determined | (u.on_bound != 0)
    if loose.any() and not nonlinear[judged].all():
        nonlinear |= judged & _follow(residuals, z, u, errors, np.flatnonzero(loose))
    return tuple(name for name, is_nonlinear in zip(u.names, nonlinear, strict=True) if is_nonlinear)


def _fall(u: Uncertainty) -> float:
    """By how much chi2 would fall yet if the curves were linear, within the parameters that may move."""
    free = u.determined & (u.on_bound == 0)
    slope = u.gradient[free]
    return float(slope @ np.linalg.lstsq(u.information[np.ix_(free, free)], slope)[0]) / 4


def _bend(
    residuals: Residuals,
    z: Float[np.ndarray, " free"],
    u: Uncertainty,
    errors: Float[np.ndarray, " free"],
    indices: Int[np.ndarray, " judged"],
) -> Bool[np.ndarray, " judged"]:
    """For which of these parameters chi2 two standard errors away is not that of linear curves."""
    # Those that are not determined have no covariance with the others, and stay.
    moves = _AWAY * np.nan_to_num(u.covariance_z[indices]) / errors[indices, None]
    points = np.clip(z + np.concatenate([moves, -moves]), 0, 1)
    chi2 = np.asarray(_chi2(residuals, jax.device_put(np.vstack([z, points]))))
    rise = (chi2[1:] - chi2[0]) / u.variance - (points - z) @ u.gradient
    expected = np.einsum("pi,ij,pj->p", points - z, u.information, points - z)
    cut_short = expected < 1  # by a wall of the box: the move is too small to tell
    bends = ~cut_short & ((rise > _FACTOR * expected) | (rise < expected / _FACTOR))
    return bends.reshape(2, -1).any(axis=0)


def _follow(
    residuals: Residuals,
    z: Float[np.ndarray, " free"],
    u: Uncertainty,
    errors: Float[np.ndarray, " free"],
    loose: Int[np.ndarray, " loose"],
) -> Bool[np.ndarray, " free"]:
    """Which parameters move with one that is loose, along its valley or into the next."""
    indices, places = zip((_NOTHING, 0.0), *itertools.product(loose, _PLACES), strict=True)
    points, chi2 = _refits(residuals, *map(jax.device_put, (z, np.asarray(indices), np.asarray(places))))
    points, chi2 = np.asarray(points), np.asarray(chi2)  # the first with nothing held
    rise = np.maximum((chi2[1:] - chi2[0]) / u.variance, 0)[:, None]
    # Of linear curves, no parameter moves by more than the root of the rise, in its standard errors.
    beyond = np.abs(points[1:] - points[0]) > (np.sqrt(rise) + _BEYOND) * errors
    return (beyond & (rise < _AS_GOOD)).any(axis=0)


@traced_once
def _chi2(residuals: Residuals, points: Float[Array, "points free"]) -> Float[Array, " points"]:
    return jax.lax.map(lambda z: jnp.square(residuals(z)).sum(), points)


@traced_once
def _refits(
    residuals: Residuals, z: Float[Array, " free"], indices: Int[Array, " points"], places: Float[Array, " points"]
) -> tuple[Float[Array, "points free"], Float[Array, " points"]]:
    return jax.lax.map(lambda held: refit(residuals, z, held[0], held[1], _STEPS), (indices, places))
