"""Measures of rows 9 to 15: light and receding objects, bars, objects that cross. `properties` defines them."""

import jax.numpy as jnp

from lgmd2jax._characterise import trials
from lgmd2jax._characterise.curves import Curves, duration, highest, integral, top
from lgmd2jax._characterise.extremes import largest, least
from lgmd2jax._characterise.row import SAME
from lgmd2jax._characterise.trials import LIGHT_LOOM, LIGHT_RECESSION, RECESSION, REFERENCE, textured

_ONSET_MS = 150.0
_SETTLED_MS = 500.0
_STRAIGHT = trials.translation()


def index(a, b):
    """(a - b)/(a + b); NaN where there is neither."""
    total = a + b
    return (a - b) / jnp.where(total > 0, total, jnp.nan)


def light_loom(curves: Curves):
    return top(curves, LIGHT_LOOM)[0], top(curves, textured(LIGHT_LOOM))[0]


def recession(curves: Curves):
    values = []
    for comes, goes in ((REFERENCE, RECESSION), (textured(REFERENCE), textured(RECESSION))):
        a, r = integral(curves(comes, goes))
        stack = curves(goes)
        late = highest(stack, stack.motion & stack.between(_ONSET_MS, jnp.inf))[0]
        values += [top(curves, goes)[0], index(a, r), late]
    return values


def light_recession(curves: Curves):
    return (duration(curves(LIGHT_RECESSION), 0.1)[0],)


def bars(curves: Curves):
    values = []
    for scene in (str, textured):
        for shade, grows in (("dark", True), ("light", False)):
            strong, weak = scene(trials.bar(shade, grows)), scene(trials.bar(shade, not grows))
            values += [index(*integral(curves(strong, weak))), top(curves, strong)[0]]
    return values


def translation(curves: Curves):
    values = []
    for name in (_STRAIGHT, textured(_STRAIGHT)):
        stack, peak = curves(name), top(curves, name)[0]
        late = highest(stack, stack.motion & stack.between(_SETTLED_MS, jnp.inf))[0]
        values += [peak, jnp.where(peak > SAME, late / jnp.where(peak > SAME, peak, 1), 0 * peak)]
    peaks = top(curves, *(trials.translation(direction=direction) for direction in trials.DIRECTIONS))
    most = largest(peaks)
    spread = jnp.where(most > SAME, (most - least(peaks)) / jnp.where(most > SAME, most, 1), 0 * most)
    return *values, 100 * spread, *top(curves, trials.translation(20.0)), *top(curves, trials.translation(200.0))


def adaptation(curves: Curves):
    adapted, unadapted = (curves(_STRAIGHT, channel=channel) for channel in ("adapted", "unadapted"))
    before, after = integral(unadapted)[0], integral(adapted)[0]
    loom = [top(curves, REFERENCE, channel=channel)[0] for channel in ("unadapted", "adapted")]
    return before / jnp.where(after > 0, after, jnp.nan), loom[0] / loom[1]


def speed(curves: Curves):
    constant, linear, squared = top(curves, *map(trials.accelerating, ("constant", "linear", "accelerating")))
    steps = jnp.diff(top(curves, *map(trials.translation, trials.SPEEDS)))
    return squared - linear, linear - constant, least(steps)
