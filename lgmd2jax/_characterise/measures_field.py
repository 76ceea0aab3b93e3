"""Measures of rows 16, 17 and 21: what fills the field, and what lies beside it. `properties` defines them."""

import jax.numpy as jnp
import numpy as np

from lgmd2jax._characterise import trials
from lgmd2jax._characterise.curves import Curves, highest, mean, top
from lgmd2jax._characterise.extremes import largest, least
from lgmd2jax._characterise.trials import CHANGES, DEVIATIONS, DRIFTING, GRATING_MS, GRATINGS, STILL

SETTLED_MS = 300.0


def gratings(curves: Curves):
    stack = curves(*(name for name in (trials.grating(*each) for each in GRATINGS) if name in curves.exam.places))
    first, late = stack.between(0.0, SETTLED_MS), stack.between(SETTLED_MS, GRATING_MS)
    return tuple(largest(each) for each in (mean(stack, late), highest(stack, first), highest(stack, stack.after())))


def changes_of_light(curves: Curves):
    stack = curves(*(trials.change(*each) for each in CHANGES))
    return tuple(highest(stack, stack.between(stack.begin, np.inf)))


def elsewhere(curves: Curves):
    still, drifting = top(curves, STILL, DRIFTING)
    tops = top(curves, *map(trials.deviating, DEVIATIONS))
    return drifting - still, largest(jnp.diff(tops)), tops[0] - tops[-1], half_width(tops)


def half_width(tops):
    """The deviation at which R has fallen to half, interpolated; infinite where it does not."""
    half, widths = tops[0] / 2, []
    for left, right, a, b in zip(DEVIATIONS, DEVIATIONS[1:], tops, tops[1:], strict=False):
        widths.append(jnp.where((a >= half) & (b < half), left + (right - left) * (a - half) / (a - b), jnp.inf))
    return least(jnp.stack(widths))
