"""Every bound of every row: neurons with a value just inside of it hold the row, and with one just outside do not."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

from lgmd2jax._characterise import trials
from lgmd2jax._characterise.properties import ROWS
from lgmd2jax._characterise.trials import textured
from tests.characterise.signals import Neuron, Signal, before_adaptation, bump, eta, examine, ideal, onset, plus, step

Changes = Callable[[float], Neuron]

SPEEDS = np.array(trials.L_OVER_V)
FRAME = 10.0  # ms
STRAIGHT = trials.translation()
SCENES = {"": str, ", textured": textured}


class Pin(NamedTuple):
    """A bound between two values of a line, and what an ideal neuron is changed to so that the line has a value."""

    row: int
    line: str
    inside: float
    outside: float
    changes: Changes
    before_adaptation: bool = False


def looms(signals: dict[float, Signal]) -> Neuron:
    """Answers to the approaches by l/|v|."""
    return {trials.loom(speed): signal for speed, signal in signals.items()}


def peaks_at_leads(leads) -> Neuron:
    """Approaches whose peaks lie so many ms before collision, 25 ms and a frame added."""
    return looms({speed: bump(25 + FRAME - lead, 1.0, 30.0) for speed, lead in zip(SPEEDS, leads, strict=True)})


def peaks_at_angles(angles) -> Neuron:
    """Approaches whose peaks, 25 ms and a frame earlier, are at full angles in degrees."""
    return peaks_at_leads(SPEEDS / np.tan(np.radians(angles) / 2))


def by_power(exponent: float, scale: float) -> Neuron:
    """Peak times that follow a power of l/|v|."""
    return peaks_at_leads(scale * SPEEDS**exponent)


def by_line(alpha: float, delta: float, rms: float = 0.0) -> Neuron:
    """Peak times about a straight line, at some distance from it; the fastest object comes first and ends before 0."""
    first = np.array([1.0, 0, 0, 0, 0, 0])
    off = first - np.polyval(np.polyfit(SPEEDS, first, 1), SPEEDS)
    return peaks_at_leads(alpha * SPEEDS - delta + 25 + rms / math.sqrt(np.mean(off**2)) * off)


def angles_about(mean: float, deviation: float) -> Neuron:
    """Three angles below their mean and three above, by their standard deviation."""
    return peaks_at_angles(mean + deviation * np.array([-1, -1, -1, 1, 1, 1]))


def large_angles(mean: float) -> Neuron:
    """Angles of such a mean; the fastest object's is as large as one can be when its motion ends."""
    fastest = 2 * math.degrees(math.atan(10 / (25 + FRAME + 5)))
    return peaks_at_angles([fastest, *[(6 * mean - fastest) / 5] * 5])


def trapezoid(peak: float, rise: float, fall: float, height: float = 1.0) -> Signal:
    """A plateau of three frames about a peak, with straight flanks, half as high `rise` before and `fall` after it."""

    def signal(time):
        before, after = (2 * (half - FRAME) for half in (rise, fall))
        return height * np.interp(time, peak + np.array([-FRAME - before, -FRAME, FRAME, FRAME + after]), [0, 1, 1, 0])

    return signal


def shapes(width: float = 2.2, rise_by_fall: float = 3.0, exponent: float = 0.0) -> Neuron:
    """Peaks on a line of slope 4, as wide at half as `width` times slope and l/|v|, and high by a power of it."""
    signals = {}
    for speed in trials.L_OVER_V:
        fall = width * 4 * speed / (1 + rise_by_fall)
        signals[speed] = trapezoid(20 - 4 * speed, rise_by_fall * fall, fall, (speed / 40) ** exponent)
    return looms(signals)


def integrals_with_step(least: float) -> Neuron:
    """Approaches of growing integrals, from l/|v| of 40 to 50 ms by `least` alone."""
    heights = {10.0: 0.7, 20.0: 0.8, 30.0: 0.9, 40.0: 1.0, 50.0: 1 + least / 200, 80.0: 1.5}
    return looms({speed: step(height, -300.0, -100.0) for speed, height in heights.items()})


ANGLE = 2 * math.degrees(math.atan(40 / (25 + FRAME - 28.7 + 4.4 * 40)))  # of eta at 40 ms, by row 3


def shifted(by: float, peak: float = 1.0) -> Signal:
    """The approach at 40 ms with its angle at the peak changed by some degrees."""
    lead = 40 / math.tan(math.radians(ANGLE + by) / 2)
    return eta(40.0, peak, delta=25 + FRAME - lead + 4.4 * 40)


def recession_by_index(index: float) -> Signal:
    """A brief onset and a weak plateau, of the integral that gives (A-R)/(A+R) with the approach at 40 ms."""
    theta = 2 * math.atan(1 / 4.4)
    peak = 2 / 40 * math.sin(theta / 2) ** 2 * math.exp(-4.4 * theta)
    approach = math.exp(-4.4 * math.radians(2)) / 4.4 / peak  # integral of eta over its angle from 2 degrees on
    rest = approach * (1 - index) / (1 + index) - 0.2 * 150
    return plus(step(0.2, 0.0, 150.0), step(0.05, 150.0, 150 + rest / 0.05))


def bars(shade: str, strong: float, weak: float) -> Callable[[Callable[[str], str]], Neuron]:
    """Peaks of the bar that darkens and of the one that lightens, in a scene."""
    grows = shade == "dark"
    return lambda scene: {
        scene(trials.bar(shade, grows)): onset(strong, 200.0),
        scene(trials.bar(shade, not grows)): onset(weak, 200.0),
    }


def deviations(*peaks: float) -> Neuron:
    """Peaks of approaches 10, 20 and 40 degrees off the eye."""
    names = map(trials.deviating, trials.DEVIATIONS[1:])
    return {name: eta(40.0, peak) for name, peak in zip(names, peaks, strict=True)}


def peak_at_another_contrast(step_from_weaker: float) -> Neuron:
    return {trials.contrast(-0.3): eta(40.0, (0.2 / 0.9) ** 0.2 + step_from_weaker)}


def everywhere(signal: Signal) -> Neuron:
    return {trials.grating(*each): signal for each in trials.GRATINGS}


def in_all_directions(signal: Signal) -> Neuron:
    return {trials.translation(direction=direction): signal for direction in trials.DIRECTIONS}


PINS = [
    Pin(1, "log-log exponent over l/|v|", 0.91, 0.89, lambda x: by_power(x, 20.0)),
    Pin(1, "log-log exponent over l/|v|", 1.09, 1.11, lambda x: by_power(x, 20.0)),
    Pin(1, "or rms about the line", 2.9, 3.1, lambda x: by_line(10.0, 65.0, x)),
    Pin(2, "alpha (aim 3.4..5.4)", 2.8, 2.7, lambda x: by_line(x, 16.0, 5.0)),
    Pin(2, "alpha (aim 3.4..5.4)", 7.5, 7.7, lambda x: by_line(x, 25.0)),
    Pin(2, "delta", 15.5, 14.5, lambda x: by_line(7.0, x)),
    Pin(2, "delta", 34.5, 35.5, lambda x: by_line(7.0, x)),
    Pin(3, "mean angle at t_peak - D", 15.5, 14.5, lambda x: angles_about(x, 0.0)),
    Pin(3, "mean angle at t_peak - D", 39.2, 40.2, large_angles),
    Pin(3, "s.d. over l/|v|", 4.8, 5.2, lambda x: angles_about(25.0, x)),
    Pin(
        4,
        "second rise of R, at most",
        0.19,
        0.21,
        lambda x: {trials.loom(80.0): plus(step(1.0, -600.0, -500.0), step(x, -400.0, -300.0))},
    ),
    *(
        Pin(5, f"FWHM/(alpha l/|v|), {which}", inside, outside, lambda x: shapes(width=x))
        for which in ("least", "largest")
        for inside, outside in ((1.82, 1.78), (2.58, 2.62))
    ),
    *(
        Pin(5, f"rise:fall, {which}", inside, outside, lambda x: shapes(rise_by_fall=x))
        for which in ("least", "largest")
        for inside, outside in ((1.34, 1.26), (4.9, 5.1))
    ),
    Pin(6, "exponent q of (l/|v|)^q", -0.49, -0.51, lambda x: shapes(exponent=x)),
    Pin(6, "exponent q of (l/|v|)^q", -0.01, 0.01, lambda x: shapes(exponent=x)),
    Pin(7, "least step of the integral", 1.5e-3, 0.5e-3, integrals_with_step),
    Pin(
        8,
        "R from 150 ms after it, at most",
        0.098,
        0.102,
        lambda x: {trials.loom(20.0): plus(eta(20.0, 1.07), step(x))},
    ),
    *(
        Pin(9, line, 0.275, 0.285, lambda x, scene=scene: {scene(trials.LIGHT_LOOM): eta(40.0, x)})
        for line, scene in (("peak of the light loom (aim .15)", str), ("textured", textured))
    ),
    *(
        Pin(10, line + words, inside, outside, lambda x, scene=scene, of=of: {scene(trials.RECESSION): of(x)})
        for words, scene in SCENES.items()
        for line, inside, outside, of in (
            ("peak", 0.245, 0.255, lambda x: onset(x, 40.0)),
            ("(A-R)/(A+R) of integrals", 0.76, 0.74, recession_by_index),
            ("R from 150 ms after the onset", 0.098, 0.102, lambda x: plus(onset(0.2, 20.0), step(x, 150.0, 200.0))),
        )
    ),
    Pin(11, "time with R above .1", 300.0, 310.0, lambda x: {trials.LIGHT_RECESSION: step(0.8, 0.0, x)}),
    *(
        Pin(12, line + words, inside, outside, lambda x, scene=scene, shade=shade, of=of: bars(shade, *of(x))(scene))
        for words, scene in SCENES.items()
        for shade, line, inside, outside, of in (
            ("dark", "dark bar: (E-S)/(E+S) of integrals", 0.51, 0.49, lambda x: (0.4, 0.4 * (1 - x) / (1 + x))),
            ("dark", "dark bar: peak of elongation", 0.052, 0.048, lambda x: (x, 0.0)),
            ("light", "light bar: (S-E)/(S+E) of integrals", 0.51, 0.49, lambda x: (0.4, 0.4 * (1 - x) / (1 + x))),
            ("light", "light bar: peak of shortening", 0.052, 0.048, lambda x: (x, 0.0)),
        )
    ),
    Pin(13, "peak at 60 deg/s", 0.49, 0.51, lambda x: in_all_directions(onset(x, 150.0))),
    Pin(13, "peak, textured", 0.49, 0.51, lambda x: {textured(STRAIGHT): onset(x, 150.0)}),
    *(
        Pin(
            13,
            f"from 500 ms on, by that peak{words}",
            0.49,
            0.51,
            lambda x, scene=scene: {scene(STRAIGHT): plus(onset(0.3, 50.0), step(0.3 * x, 500.0, 600.0))},
        )
        for words, scene in SCENES.items()
    ),
    Pin(
        13,
        "spread of four directions",
        4.8,
        5.2,
        lambda x: {trials.translation(direction=180.0): onset(0.3 * (1 - x / 100), 150.0)},
    ),
    Pin(
        14,
        "without adaptation: integral of translation x",
        1.52,
        1.48,
        lambda x: {STRAIGHT: onset(0.3 * x, 150.0)},
        True,
    ),
    Pin(14, "without adaptation: peak of the loom x", 1.14, 1.16, lambda x: {trials.REFERENCE: eta(40.0, x)}, True),
    Pin(
        15,
        "R: speed ~ t^2 above speed ~ t by",
        1.5e-3,
        0.5e-3,
        lambda x: {trials.accelerating("accelerating"): onset(0.35 + x, 150.0)},
    ),
    Pin(
        15,
        "R: speed ~ t above constant by",
        -0.5e-3,
        -1.5e-3,
        lambda x: {trials.accelerating("linear"): onset(0.3 + x, 150.0)},
    ),
    Pin(
        15,
        "least step of R, 20..200 deg/s",
        -0.5e-3,
        -1.5e-3,
        lambda x: {trials.translation(200.0): onset(0.3 * (100 / 60) ** 0.5 + x, 150.0)},
    ),
    Pin(16, "mean R, 300..2,000 ms, at most", 0.098, 0.102, lambda x: everywhere(step(x, 300.0, 2000.0))),
    Pin(16, "peak in the first 300 ms, at most", 0.345, 0.355, lambda x: {trials.grating(0.1, 4.0): onset(x, 50.0)}),
    *(
        Pin(17, name, 0.148, 0.152, lambda x, name=name: {name: step(x, 200.0, 300.0)})
        for name in (trials.change(*change) for change in trials.CHANGES)
    ),
    Pin(18, "least step of R with |Weber|", -0.5e-3, -1.5e-3, peak_at_another_contrast),
    Pin(18, "R(-.9)/R(-1)", 0.955, 0.945, lambda x: {trials.contrast(-1.0): eta(40.0, 1 / x)}),
    Pin(18, "range of the angle at peak, -.3..-1", 4.8, 5.2, lambda x: {trials.contrast(-0.5): shifted(x, 0.9)}),
    *(
        Pin(19, "change of the peak", sign * 14.8, sign * 15.2, lambda x: {trials.HALVED: eta(40.0, 1 + x / 100)})
        for sign in (-1, 1)
    ),
    *(
        Pin(19, "change of the angle at peak", sign * 4.8, sign * 5.2, lambda x: {trials.HALVED: shifted(x)})
        for sign in (-1, 1)
    ),
    *(
        Pin(20, f"{what}: change of the angle at peak", sign * 4.8, sign * 5.2, lambda x, name=name: {name: shifted(x)})
        for what, name in (("square", trials.SQUARE), ("checks", trials.CHECKS))
        for sign in (-1, 1)
    ),
    *(
        Pin(20, f"{what}: ratio of the peaks", inside, outside, lambda x, name=name: {name: eta(40.0, x)})
        for what, name in (("square", trials.SQUARE), ("checks", trials.CHECKS))
        for inside, outside in ((0.81, 0.79), (1.24, 1.26))
    ),
    Pin(
        21,
        "photograph drifting at 20 deg/s changes R by",
        -1.5e-3,
        -0.5e-3,
        lambda x: {trials.DRIFTING: eta(40.0, 1 + x)},
    ),
    Pin(21, "largest step of R with deviation", 0.5e-3, 1.5e-3, lambda x: deviations(0.5, 0.5 + x, 0.2)),
    Pin(21, "R straight on above R 40 deg off by", 0.051, 0.049, lambda x: deviations(0.99, 0.98, 1 - x)),
    Pin(
        22,
        "shift of the peak at 200 fps, at most",
        4.8,
        5.2,
        lambda x: {trials.loom(80.0, fine): bump(-300 + fine * x, 0.93, 80.0) for fine in (False, True)},
    ),
]  # fmt: skip


@pytest.mark.parametrize("side", ["inside", "outside"])
@pytest.mark.parametrize("pin", PINS, ids=lambda pin: f"{pin.row} {pin.line} {pin.inside:g} {pin.outside:g}")
def test_a_row_holds_just_inside_of_each_bound_and_not_outside(pin: Pin, side):
    value, row = getattr(pin, side), ROWS[pin.row - 1]
    changes = pin.changes(value)
    assert set(changes) <= set(ideal())
    if pin.before_adaptation:
        measurements = examine(ideal(), before_adaptation(ideal()) | changes)
    else:
        measurements = examine(ideal() | changes)
    (number,) = (i for i, line in enumerate(row.lines) if line.label == pin.line)
    measured = float(measurements.values[pin.row - 1][number])
    assert measured == pytest.approx(value, abs=abs(pin.inside - pin.outside) / 4)
    assert bool(row.lines[number].holds(measured)) == (side == "inside")
    assert bool(measurements.passed[pin.row - 1]) == (side == "inside")


def test_every_bound_is_pinned():
    bounds = {
        (row.number, line.label, bound)
        for row in ROWS
        for line in row.lines
        for bound in (line.low, line.high)
        if math.isfinite(bound)
    }
    pinned = {bound for bound in bounds for pin in PINS if _lies_between(pin, *bound)}
    assert pinned == bounds
    assert len(PINS) == len(bounds)


def _lies_between(pin: Pin, row: int, line: str, bound: float) -> bool:
    near = abs(pin.inside - pin.outside) <= max(0.1 * abs(bound), 0.02)
    return (pin.row, pin.line) == (row, line) and near and (pin.inside - bound) * (pin.outside - bound) <= 0
