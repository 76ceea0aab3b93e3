"""Rows 16, 17 and 21: what fills the field, and what lies beside it."""

import jax.numpy as jnp
import numpy as np

from lgmd2jax._characterise import trials
from lgmd2jax._characterise.curves import Curves, highest, mean, top
from lgmd2jax._characterise.extremes import largest, least
from lgmd2jax._characterise.row import SAME, Line, row
from lgmd2jax._characterise.trials import CHANGES, DEVIATIONS, DRIFTING, GRATING_MS, GRATINGS, STILL

SETTLED_MS = 300.0


@row(
    16,
    "gratings are answered at first alone",
    Line("mean R, 300..2,000 ms, at most", high=0.1),
    Line("peak in the first 300 ms, at most", high=0.35),
    Line("burst at the stop, at most"),
)
def gratings(it: Curves):
    """.05, .1, .2 cyc/deg at 1, 4, 10 Hz as far as the eye samples them, Michelson 1 on 110; the worst of them."""
    stack = it(*(name for name in (trials.grating(*each) for each in GRATINGS) if name in it.exam.places))
    first, late = stack.between(0.0, SETTLED_MS), stack.between(SETTLED_MS, GRATING_MS)
    return tuple(largest(each) for each in (mean(stack, late), highest(stack, first), highest(stack, stack.after())))


@row(17, "changes of light", *(Line(trials.change(*each), high=0.15) for each in CHANGES))
def changes_of_light(it: Curves):
    """Largest R from the onset to the end of the clip, up from 60 and down from 200, whole field and its quarter."""
    stack = it(*(trials.change(*each) for each in CHANGES))
    return tuple(highest(stack, stack.between(stack.begin, np.inf)))


@row(
    21,
    "what else moves, and near misses",
    Line("photograph drifting at 20 deg/s changes R by", high=-SAME, evidence="A"),
    Line("largest step of R with deviation", high=SAME, evidence="A"),
    Line("R straight on above R 40 deg off by", low=0.05),
    Line("half-width (animal 2..3)", "deg", evidence="A"),
)
def elsewhere(it: Curves):
    """Loom over "gravel" of its own levels, drifting against still; and looms 0, 10, 20, 40 deg off the eye."""
    still, drifting = top(it, STILL, DRIFTING)
    tops = top(it, *map(trials.deviating, DEVIATIONS))
    return drifting - still, largest(jnp.diff(tops)), tops[0] - tops[-1], half_width(tops)


def half_width(tops):
    """The deviation at which R has fallen to half, interpolated; infinite where it does not."""
    half, widths = tops[0] / 2, []
    for left, right, a, b in zip(DEVIATIONS, DEVIATIONS[1:], tops, tops[1:], strict=False):
        widths.append(jnp.where((a >= half) & (b < half), left + (right - left) * (a - half) / (a - b), jnp.inf))
    return least(jnp.stack(widths))
