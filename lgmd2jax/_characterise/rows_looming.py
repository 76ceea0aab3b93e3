"""Rows 1 to 8, 18 to 20 and 22: when and how the cell answers a dark object that comes straight at it."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._characterise import trials
from lgmd2jax._characterise.curves import Curves, highest, integral, peak, rise, rise_and_fall, second_rise, top
from lgmd2jax._characterise.extremes import largest, least
from lgmd2jax._characterise.row import SAME, Line, row
from lgmd2jax._characterise.trials import L_OVER_V, REFERENCE
from lgmd2jax._signals import line_through
from lgmd2jax._types import Scalar

_ALLOWANCE = 25.0  # ms, for delta, so that rows do not lean on their own fit; a frame is added to it
LOOMS = tuple(trials.loom(it) for it in L_OVER_V)
_SPEEDS = np.array(L_OVER_V)
_SLOW = _SPEEDS >= 20
_STRONG = tuple(trials.contrast(it) for it in trials.CONTRASTS if it <= -0.3)


def peak_leads(it: Curves, *names: str) -> Float[Array, " trial"]:
    """How long before collision the cell peaks, in ms, the allowance for its delay added."""
    stack = it(*names)
    return _ALLOWANCE + stack.frame - peak(stack)[1]


def law_of_peaks(it: Curves) -> tuple[Scalar, Scalar]:
    """alpha, and delta in ms less a frame, of t_c - t_peak = alpha l/|v| - delta."""
    slope, intercept, _ = line_through(peak_leads(it, *LOOMS), _SPEEDS)
    return slope, _ALLOWANCE - intercept


def angles_at_peak(
    it: Curves, *names: str, l_over_v: Float[np.ndarray, " trial"] | float = 40.0
) -> Float[Array, " trial"]:
    """The full angle in degrees, that of a disc, by the allowance before the peak."""
    return 2 * jnp.degrees(jnp.arctan2(l_over_v, peak_leads(it, *names)))


def _range(values):
    return largest(values) - least(values)


@row(
    1,
    "peak times follow a line",
    Line("log-log exponent over l/|v|", low=0.9, high=1.1),
    Line("or rms about the line", "ms", high=3),
    Line("r2 of the line"),
    any_of=True,
)
def linear_law(it: Curves):
    """t_c - t_peak + D against l/|v| of 10 to 80 ms; D = 25 ms + a frame."""
    leads = peak_leads(it, *LOOMS)
    exponent = line_through(jnp.log(jnp.where(leads > 0, leads, jnp.nan)), np.log(_SPEEDS))[0]
    rest = line_through(leads, _SPEEDS)[2]
    spread = jnp.sum((leads - jnp.mean(leads)) ** 2)
    return exponent, jnp.sqrt(jnp.mean(rest**2)), 1 - jnp.sum(rest**2) / jnp.where(spread > 0, spread, jnp.nan)


@row(
    2,
    "slope and delay of that line",
    Line("alpha (aim 3.4..5.4)", low=2.75, high=7.6, evidence="A"),
    Line("delta", "ms", low=15, high=35, evidence="A"),
)
def slope_and_delay(it: Curves):
    """t_c - t_peak = alpha l/|v| - delta by least squares; a frame is taken off delta."""
    return law_of_peaks(it)


@row(
    3,
    "one threshold angle",
    Line("mean angle at t_peak - D", "deg", low=15, high=40, evidence="A"),
    Line("s.d. over l/|v|", "deg", high=5),
)
def threshold_angle(it: Curves):
    """The full angle D before the peak, mean and s.d. (of the six) over l/|v|."""
    seen = angles_at_peak(it, *LOOMS, l_over_v=_SPEEDS)
    return jnp.mean(seen), jnp.std(seen)


@row(4, "one peak", Line("second rise of R, at most", high=0.2))
def one_peak(it: Curves):
    """The largest rise of R after a dip, on either side of the peak, over all approaches from 2 degrees."""
    return (largest(second_rise(it(*LOOMS))),)


@row(
    5,
    "width and shape of the peak",
    Line("FWHM/(alpha l/|v|), least", low=1.8, high=2.6),
    Line("FWHM/(alpha l/|v|), largest", low=1.8, high=2.6),
    Line("rise:fall, least", low=1.3, high=5),
    Line("rise:fall, largest", low=1.3, high=5),
)
def width(it: Curves):
    """At half of each peak, for l/|v| of 20 ms and more, with the model's own alpha of row 2."""
    up, down = rise_and_fall(it(*(name for name, slow in zip(LOOMS, _SLOW, strict=True) if slow)))
    shares = (up + down) / (law_of_peaks(it)[0] * _SPEEDS[_SLOW])
    return least(shares), largest(shares), least(up / down), largest(up / down)


@row(6, "peaks fall gently with l/|v|", Line("exponent q of (l/|v|)^q", low=-0.5, high=0, evidence="DM"))
def peak_exponent(it: Curves):
    """Slope of log peak over log l/|v|."""
    return (line_through(jnp.log(top(it, *LOOMS)), np.log(_SPEEDS))[0],)


@row(7, "the integral rises with l/|v|", Line("least step of it", "ms", low=SAME, evidence="D"))
def integral_rises(it: Curves):
    """Time integral of R, from onset to 150 ms after the motion: smallest step from one l/|v| to the next."""
    return (least(jnp.diff(integral(it(*LOOMS)))),)


@row(
    8,
    "silent after the motion",
    Line("R from 150 ms after it, at most", high=0.1),
    Line("rebound: rise of R after the motion"),
)
def silence(it: Curves):
    """Largest R over all approaches, up to the end of the clip; the rebound is the gate that reopens."""
    stack = it(*LOOMS)
    return largest(highest(stack, stack.after(150.0))), largest(rise(stack, stack.after()))


@row(
    18,
    "contrast",
    Line("least step of R with |Weber|", low=-SAME),
    Line("R(-.9)/R(-1)", low=0.95, evidence="A"),
    Line("range of the angle at peak, -.3..-1", "deg", high=5, evidence="A"),
)
def contrast(it: Curves):
    """Peak and angle at t_peak - D of the approach at 40 ms, Weber -.1 to -1."""
    tops = top(it, *map(trials.contrast, trials.CONTRASTS))
    return least(jnp.diff(tops)), tops[-2] / tops[-1], _range(angles_at_peak(it, *_STRONG))


@row(
    19,
    "all luminances halved",
    Line("change of the peak", "%", low=-15, high=15, evidence="DP"),
    Line("change of the angle at peak", "deg", low=-5, high=5),
)
def halved(it: Curves):
    """10 on 100 instead of 20 on 200, approach at 40 ms."""
    names = REFERENCE, trials.HALVED
    tops, seen = top(it, *names), angles_at_peak(it, *names)
    return 100 * (tops[1] / tops[0] - 1), seen[1] - seen[0]


@row(
    20,
    "form and texture of the object",
    Line("square: change of the angle at peak", "deg", low=-5, high=5, evidence="A"),
    Line("square: ratio of the peaks", low=0.8, high=1.25),
    Line("checks: change of the angle at peak", "deg", low=-5, high=5, evidence="A"),
    Line("checks: ratio of the peaks", low=0.8, high=1.25),
)
def form(it: Curves):
    """A square, plain and of 4 x 4 checks of 20 and 110, against the disc of equal area, whose angle is stated."""
    names = REFERENCE, trials.SQUARE, trials.CHECKS
    tops, seen = top(it, *names), angles_at_peak(it, *names)
    return seen[1] - seen[0], tops[1] / tops[0], seen[2] - seen[0], tops[2] / tops[0]


@row(22, "another frame rate", Line("shift of the peak at 200 fps, at most", "ms", high=5))
def frame_rate(it: Curves):
    """All that counts per frame scaled to 200 fps (twice its own from there on), l/|v| of 40, 50 and 80 ms."""
    own = peak(it(*(trials.loom(speed) for speed in trials.FINE_RATES)))[1]
    fine = peak(it(*(trials.loom(speed, fine=True) for speed in trials.FINE_RATES)))[1]
    return (largest(jnp.abs(fine - own)),)
