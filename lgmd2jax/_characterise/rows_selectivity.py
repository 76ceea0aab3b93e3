"""Rows 9 to 15: light and receding objects, bars, objects that cross the field."""

import jax.numpy as jnp

from lgmd2jax._characterise import trials
from lgmd2jax._characterise.curves import Curves, duration, highest, integral, top
from lgmd2jax._characterise.extremes import largest, least
from lgmd2jax._characterise.row import SAME, Line, row
from lgmd2jax._characterise.trials import LIGHT_LOOM, LIGHT_RECESSION, RECESSION, REFERENCE, textured

_ONSET_MS = 150.0
_SETTLED_MS = 500.0
_STRAIGHT = trials.translation()


def index(a, b):
    """(a - b)/(a + b); NaN where there is neither."""
    total = a + b
    return (a - b) / jnp.where(total > 0, total, jnp.nan)


@row(
    9,
    "light looms are weak",
    Line("peak of the light loom (aim .15)", high=0.28, evidence="A"),
    Line("textured", high=0.28),
    neuron="LGMD2",
)
def light_loom(it: Curves):
    """Light disc at 40 ms; textured: checks over a photograph, by the dark loom of the same scene."""
    return top(it, LIGHT_LOOM)[0], top(it, textured(LIGHT_LOOM))[0]


@row(
    10,
    "dark recession is weak",
    *(
        Line(f"{label}{scene}", high=high, low=low)
        for scene in ("", ", textured")
        for label, low, high in (
            ("peak", -jnp.inf, 0.25),
            ("(A-R)/(A+R) of integrals", 0.75, jnp.inf),
            ("R from 150 ms after the onset", -jnp.inf, 0.1),
        )
    ),
    neuron="LGMD2",
)
def recession(it: Curves):
    """Approach against recession at 40 ms; what recession is answered lies within 150 ms of its onset."""
    values = []
    for comes, goes in ((REFERENCE, RECESSION), (textured(REFERENCE), textured(RECESSION))):
        a, r = integral(it(comes, goes))
        stack = it(goes)
        late = highest(stack, stack.motion & stack.between(_ONSET_MS, jnp.inf))[0]
        values += [top(it, goes)[0], index(a, r), late]
    return values


@row(11, "light recession is brief", Line("time with R above .1", "ms", high=300), neuron="LGMD2")
def light_recession(it: Curves):
    """In all from the onset to the end of the clip, light disc at 40 ms; below 300 ms."""
    return (duration(it(LIGHT_RECESSION), 0.1)[0],)


@row(
    12,
    "only edges that darken count",
    *(
        Line(f"{label}{scene}", low=low)
        for scene in ("", ", textured")
        for label, low in (
            ("dark bar: (E-S)/(E+S) of integrals", 0.5),
            ("dark bar: peak of elongation", 0.05),
            ("light bar: (S-E)/(S+E) of integrals", 0.5),
            ("light bar: peak of shortening", 0.05),
        )
    ),
    neuron="LGMD2",
)
def bars(it: Curves):
    """Elongation (E) and shortening (S) of bars 16 deg wide, edge at 60 deg/s; textured: over a photograph, noise."""
    values = []
    for scene in (str, textured):
        for shade, grows in (("dark", True), ("light", False)):
            strong, weak = (scene(trials.bar(shade, it)) for it in (grows, not grows))
            values += [index(*integral(it(strong, weak))), top(it, strong)[0]]
    return values


@row(
    13,
    "translation is answered at first alone",
    Line("peak at 60 deg/s", high=0.5),
    Line("from 500 ms on, by that peak", high=0.5),
    Line("peak, textured", high=0.5),
    Line("from 500 ms on, by that peak, textured", high=0.5),
    Line("spread of four directions", "%", high=5),
    Line("peak at 20 deg/s"),
    Line("peak at 200 deg/s"),
)
def translation(it: Curves):
    """Disc of 10 deg over -40..40 deg; directions (largest - least)/largest, on the plain ground, where all fit."""
    values = []
    for name in (_STRAIGHT, textured(_STRAIGHT)):
        stack, peak = it(name), top(it, name)[0]
        late = highest(stack, stack.motion & stack.between(_SETTLED_MS, jnp.inf))[0]
        values += [peak, jnp.where(peak > SAME, late / jnp.where(peak > SAME, peak, 1), 0 * peak)]
    peaks = top(it, *(trials.translation(direction=it) for it in trials.DIRECTIONS))
    most = largest(peaks)
    spread = jnp.where(most > SAME, (most - least(peaks)) / jnp.where(most > SAME, most, 1), 0 * most)
    return *values, 100 * spread, *top(it, trials.translation(20.0)), *top(it, trials.translation(200.0))


@row(
    14,
    "adaptation acts on translation",
    Line("without it: integral of translation x", low=1.5, evidence="AP"),
    Line("without it: peak of the loom x", high=1.15, evidence="AP"),
)
def adaptation(it: Curves):
    """SMP before adaptation by the SMP after it; directions Peron & Gabbiani 2009."""
    adapted, unadapted = (it(_STRAIGHT, channel=channel) for channel in ("adapted", "unadapted"))
    before, after = integral(unadapted)[0], integral(adapted)[0]
    loom = [top(it, REFERENCE, channel=channel)[0] for channel in ("unadapted", "adapted")]
    return before / jnp.where(after > 0, after, jnp.nan), loom[0] / loom[1]


@row(
    15,
    "faster is stronger",
    Line("R: speed ~ t^2 above speed ~ t by", low=SAME, evidence="A"),
    Line("R: speed ~ t above constant by", low=-SAME, evidence="A"),
    Line("least step of R, 20..200 deg/s", low=-SAME),
)
def speed(it: Curves):
    """Peaks of a disc that crosses 80 deg in 1,333 ms; and at constant speeds of 20, 40, 60, 100, 200 deg/s."""
    constant, linear, squared = top(it, *map(trials.accelerating, ("constant", "linear", "accelerating")))
    steps = jnp.diff(top(it, *map(trials.translation, trials.SPEEDS)))
    return squared - linear, linear - constant, least(steps)
