"""Intervals by profile likelihood: one parameter is moved, all others are fitted anew, as in MINOS."""

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
import scipy
from jaxtyping import Array, Float

from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._types import strong
from lgmd2jax.fitting._solver.levenberg_marquardt import BoundedLevenbergMarquardt
from lgmd2jax.fitting._uncertainty.covariance import CONFIDENCE, Uncertainty

# Relative, how close the rise at an end comes to its limit.
_CLOSE = 1e-3
_TRIALS = 20


@dataclasses.dataclass(frozen=True)
class Profile:
    """How chi2 rises as a parameter is moved, in its own unit.

    - `values`, `rise`: sorted points, and chi2 above its minimum there, per variance.
    - `interval`: where the rise reaches `limit`. `is_open`: ends at which it does not within the bounds.
    """

    values: Float[np.ndarray, " points"]
    rise: Float[np.ndarray, " points"]
    interval: tuple[float, float]
    is_open: tuple[bool, bool]
    limit: float

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> "Profile":
        """The profile from plain data, as JSON gives it back."""
        low, high = plain["interval"]
        below, above = plain["is_open"]
        values, rise = (np.array(plain[name], float) for name in ("values", "rise"))
        return cls(values, rise, (low, high), (below, above), plain["limit"])

    def plain(self) -> dict[str, Any]:
        """All as plain data for JSON."""
        return dataclasses.asdict(self) | {"values": self.values.tolist(), "rise": self.rise.tolist()}


def rise_limit(u: Uncertainty, confidence: float) -> float:
    """By how much chi2 / variance rises up to the end of an interval of one parameter.

    With errors that are only relative, the residual variance is known no better than its degrees of freedom allow.
    """
    if u.absolute:
        return float(scipy.stats.chi2.ppf(confidence, 1))
    return float(scipy.stats.f.ppf(confidence, 1, u.degrees_of_freedom))


def profile_likelihood(
    residuals: Callable[[Float[Array, " free"]], Float[Array, " n"]],
    z: Float[np.ndarray, " free"],
    index: int | np.integer,
    *,
    variance: float,
    limit: float,
    step: float,
    value: Callable[[float], float] = float,
    max_steps: int = 100,
) -> Profile:
    """Move parameter `index` away from its best value until chi2 / variance has risen by `limit`, to both sides.

    **Arguments:** `residuals` by a point of the unit box, correlated ones already counted as fractions; `z` the best
    point; `step` the first distance tried, such as two standard errors; `value` maps to the parameter's own unit.
    """
    minimum, best = refit(residuals, jax.device_put(z), np.asarray(-1), strong(0.0), max_steps)
    start = float(np.asarray(minimum)[index])
    rises, points = {start: 0.0}, {start: minimum}

    def rise(x: float) -> float:
        nearest = min(points, key=lambda other: abs(other - x))
        points[x], chi2 = refit(residuals, points[nearest], np.asarray(index), strong(x), max_steps)
        rises[x] = (float(chi2) - float(best)) / variance
        return rises[x]

    ends = [_crossing(rise, start, sign, step, limit) for sign in (-1, 1)]
    order = sorted(rises)
    return Profile(
        values=np.array([value(x) for x in order]),
        rise=np.array([rises[x] for x in order]),
        interval=(value(0.0 if ends[0] is None else ends[0]), value(1.0 if ends[1] is None else ends[1])),
        is_open=(ends[0] is None, ends[1] is None),
        limit=limit,
    )


def profiled_intervals(
    residuals: Callable[[Float[Array, " free"]], Float[Array, " n"]],
    z: Float[np.ndarray, " free"],
    u: Uncertainty,
    value: Callable[[Float[np.ndarray, " free"]], Float[np.ndarray, " free"]],
) -> Float[np.ndarray, "free 2"]:
    """The intervals of all parameters that are determined, by profile likelihood; of the others those there are.

    **Arguments:** `residuals` as of `profile_likelihood`; `z` the best point, `u` its uncertainty; `value` maps points
    of the unit box to the parameters' own units.
    """
    intervals = u.intervals.copy()
    for index in np.flatnonzero(u.determined):
        limit, step = rise_limit(u, CONFIDENCE), first_step(u, index)
        profile = profile_likelihood(residuals, z, index, variance=u.variance, limit=limit, step=step)
        intervals[index] = [value(np.where(np.arange(len(z)) == index, end, z))[index] for end in profile.interval]
    return intervals


def first_step(u: Uncertainty, index: int | np.integer) -> float:
    """How far from the best point a profile is tried first, in the unit box: two standard errors, within reason."""
    return min(max(2 * float(np.sqrt(u.covariance_z[index, index])), 1e-4), 0.25)


def _crossing(rise: Callable[[float], float], start: float, sign: int, step: float, limit: float) -> float | None:
    """Where the rise reaches the limit: out in growing steps, then in between by false position (Illinois).

    The root of the rise is nearly a straight line, hence easier to follow.
    """

    def excess(x: float) -> float:
        return float(np.sqrt(max(rise(x), 0)) - np.sqrt(limit))

    wall = 0.0 if sign < 0 else 1.0
    inner, low, outer, high = start, -np.sqrt(limit), start, -1.0
    while high < 0:
        if outer == wall:
            return None
        outer = min(max(outer + sign * step, 0.0), 1.0)
        high = excess(outer)
        if high < 0:
            inner, low = outer, high
        step *= 2
    x, side = outer, 0
    for _ in range(_TRIALS):
        x = (inner * high - outer * low) / (high - low)
        now = excess(x)
        if abs(now) < _CLOSE * np.sqrt(limit):
            break
        if now < 0:
            inner, low, high, side = x, now, high / (2 if side < 0 else 1), -1
        else:
            outer, high, low, side = x, now, low / (2 if side > 0 else 1), 1
    return x


@traced_once
def refit(residuals, z, index, x, max_steps: int):
    """The best point with entry `index` held at x (with index -1 nothing is held), and chi2 there."""
    held = jnp.arange(len(z)) == index
    lower, upper = jnp.where(held, x, 0.0), jnp.where(held, x, 1.0)
    solution = optx.least_squares(
        lambda z, _: residuals(z),
        BoundedLevenbergMarquardt(1e-5, 1e-9, lower, upper),
        jnp.where(held, x, z),
        throw=False,
        max_steps=max_steps,
    )
    return solution.value, jnp.sum(jnp.square(residuals(solution.value)))
