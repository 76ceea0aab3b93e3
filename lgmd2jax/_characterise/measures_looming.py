"""Measures of rows 1 to 8, 18 to 20 and 22: when and how the cell answers a dark object that comes straight at it.

`properties` defines them.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._characterise import trials
from lgmd2jax._characterise.curves import Curves, highest, integral, peak, rise, rise_and_fall, second_rise, top
from lgmd2jax._characterise.extremes import largest, least
from lgmd2jax._characterise.trials import L_OVER_V, REFERENCE
from lgmd2jax._signals import line_through
from lgmd2jax._types import Scalar

_ALLOWANCE = 25.0  # ms, for delta, so that rows do not lean on their own fit; a frame comes on top
LOOMS = tuple(map(trials.loom, L_OVER_V))
_SPEEDS = np.array(L_OVER_V)
_SLOW = _SPEEDS >= 20
_STRONG = tuple(trials.contrast(weber) for weber in trials.CONTRASTS if weber <= -0.3)


def peak_leads(curves: Curves, *names: str) -> Float[Array, " trial"]:
    """How long before collision the cell peaks, in ms, the allowance for its delay added."""
    stack = curves(*names)
    return _ALLOWANCE + stack.frame - peak(stack)[1]


def law_of_peaks(curves: Curves) -> tuple[Scalar, Scalar]:
    """alpha, and delta in ms less a frame, of t_c - t_peak = alpha l/|v| - delta."""
    slope, intercept, _ = line_through(peak_leads(curves, *LOOMS), _SPEEDS)
    return slope, _ALLOWANCE - intercept


def angles_at_peak(
    curves: Curves, *names: str, l_over_v: Float[np.ndarray, " trial"] | float = 40.0
) -> Float[Array, " trial"]:
    """The full angle in degrees, that of a disc, by the allowance before the peak."""
    return 2 * jnp.degrees(jnp.arctan2(l_over_v, peak_leads(curves, *names)))


def _range(values):
    return largest(values) - least(values)


def linear_law(curves: Curves):
    leads = peak_leads(curves, *LOOMS)
    exponent = line_through(jnp.log(jnp.where(leads > 0, leads, jnp.nan)), np.log(_SPEEDS))[0]
    rest = line_through(leads, _SPEEDS)[2]
    spread = jnp.sum((leads - jnp.mean(leads)) ** 2)
    return exponent, jnp.sqrt(jnp.mean(rest**2)), 1 - jnp.sum(rest**2) / jnp.where(spread > 0, spread, jnp.nan)


def threshold_angle(curves: Curves):
    angles = angles_at_peak(curves, *LOOMS, l_over_v=_SPEEDS)
    return jnp.mean(angles), jnp.std(angles)


def one_peak(curves: Curves):
    return (largest(second_rise(curves(*LOOMS))),)


def width(curves: Curves):
    up, down = rise_and_fall(curves(*(name for name, slow in zip(LOOMS, _SLOW, strict=True) if slow)))
    shares = (up + down) / (law_of_peaks(curves)[0] * _SPEEDS[_SLOW])
    return least(shares), largest(shares), least(up / down), largest(up / down)


def peak_exponent(curves: Curves):
    return (line_through(jnp.log(top(curves, *LOOMS)), np.log(_SPEEDS))[0],)


def integral_rises(curves: Curves):
    return (least(jnp.diff(integral(curves(*LOOMS)))),)


def silence(curves: Curves):
    stack = curves(*LOOMS)
    return largest(highest(stack, stack.after(150.0))), largest(rise(stack, stack.after()))


def contrast(curves: Curves):
    tops = top(curves, *map(trials.contrast, trials.CONTRASTS))
    return least(jnp.diff(tops)), tops[-2] / tops[-1], _range(angles_at_peak(curves, *_STRONG))


def halved(curves: Curves):
    names = REFERENCE, trials.HALVED
    tops, angles = top(curves, *names), angles_at_peak(curves, *names)
    return 100 * (tops[1] / tops[0] - 1), angles[1] - angles[0]


def form(curves: Curves):
    names = REFERENCE, trials.SQUARE, trials.CHECKS
    tops, angles = top(curves, *names), angles_at_peak(curves, *names)
    return angles[1] - angles[0], tops[1] / tops[0], angles[2] - angles[0], tops[2] / tops[0]


def frame_rate(curves: Curves):
    own = peak(curves(*(trials.loom(speed) for speed in trials.FINE_RATES)))[1]
    fine = peak(curves(*(trials.loom(speed, fine=True) for speed in trials.FINE_RATES)))[1]
    return (largest(jnp.abs(fine - own)),)
