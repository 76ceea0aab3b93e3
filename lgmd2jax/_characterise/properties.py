"""The 22 response properties: what is measured for each, within which bounds it holds, and on what evidence."""

import math

from lgmd2jax._characterise import (
    measures_field as field,
    measures_looming as looming,
    measures_selectivity as selectivity,
    trials,
)
from lgmd2jax._characterise.row import SAME, Line, Row

_SCENES = ("", ", textured")

ROWS: tuple[Row, ...] = (
    Row(
        1,
        "peak times follow a line",
        "t_c - t_peak + D against l/|v| of 10 to 80 ms; D = 25 ms + a frame.",
        looming.linear_law,
        (
            Line("log-log exponent over l/|v|", low=0.9, high=1.1),
            Line("or rms about the line", "ms", high=3),
            Line("r2 of the line"),
        ),
        holds_if="any line holds",
    ),
    Row(
        2,
        "slope and delay of that line",
        "t_c - t_peak = alpha l/|v| - delta by least squares; a frame is taken off delta.",
        looming.law_of_peaks,
        (
            Line("alpha (aim 3.4..5.4)", low=2.75, high=7.6, evidence="A"),
            Line("delta", "ms", low=15, high=35, evidence="A"),
        ),
    ),
    Row(
        3,
        "one threshold angle",
        "The full angle D before the peak, mean and s.d. (of the six) over l/|v|.",
        looming.threshold_angle,
        (
            Line("mean angle at t_peak - D", "deg", low=15, high=40, evidence="A"),
            Line("s.d. over l/|v|", "deg", high=5),
        ),
    ),
    Row(
        4,
        "one peak",
        "The largest rise of R after a dip, on either side of the peak, over all approaches from 2 degrees.",
        looming.one_peak,
        (Line("second rise of R, at most", high=0.2),),
    ),
    Row(
        5,
        "width and shape of the peak",
        "At half of each peak, for l/|v| of 20 ms and more, with the model's own alpha of row 2.",
        looming.width,
        (
            Line("FWHM/(alpha l/|v|), least", low=1.8, high=2.6),
            Line("FWHM/(alpha l/|v|), largest", low=1.8, high=2.6),
            Line("rise:fall, least", low=1.3, high=5),
            Line("rise:fall, largest", low=1.3, high=5),
        ),
    ),
    Row(
        6,
        "peaks fall gently with l/|v|",
        "Slope of log peak over log l/|v|.",
        looming.peak_exponent,
        (Line("exponent q of (l/|v|)^q", low=-0.5, high=0, evidence="DM"),),
    ),
    Row(
        7,
        "the integral rises with l/|v|",
        "Time integral of R, from onset to 150 ms after the motion: smallest step from one l/|v| to the next.",
        looming.integral_rises,
        (Line("least step of the integral", "ms", low=SAME, evidence="D"),),
    ),
    Row(
        8,
        "silent after the motion",
        "Largest R over all approaches, up to the end of the clip; the rebound is the gate that reopens.",
        looming.silence,
        (
            Line("R from 150 ms after it, at most", high=0.1),
            Line("rebound: rise of R after the motion"),
        ),
    ),
    Row(
        9,
        "light looms are weak",
        "Light disc at 40 ms; textured: checks over a photograph, by the dark loom of the same scene.",
        selectivity.light_loom,
        (
            Line("peak of the light loom (aim .15)", high=0.28, evidence="A"),
            Line("textured", high=0.28),
        ),
        neuron="LGMD2",
    ),
    Row(
        10,
        "dark recession is weak",
        "Approach against recession at 40 ms; a response lies within 150 ms of the onset.",
        selectivity.recession,
        tuple(
            Line(f"{label}{scene}", low=low, high=high)
            for scene in _SCENES
            for label, low, high in (
                ("peak", -math.inf, 0.25),
                ("(A-R)/(A+R) of integrals", 0.75, math.inf),
                ("R from 150 ms after the onset", -math.inf, 0.1),
            )
        ),
        neuron="LGMD2",
    ),
    Row(
        11,
        "light recession is brief",
        "Total from the onset to the end of the clip, light disc at 40 ms; below 300 ms.",
        selectivity.light_recession,
        (Line("time with R above .1", "ms", high=300),),
        neuron="LGMD2",
    ),
    Row(
        12,
        "only edges that darken count",
        "Elongation (E) and shortening (S) of bars 16 deg wide, edge at 60 deg/s; textured: over a photograph, noise.",
        selectivity.bars,
        tuple(
            Line(f"{label}{scene}", low=low)
            for scene in _SCENES
            for label, low in (
                ("dark bar: (E-S)/(E+S) of integrals", 0.5),
                ("dark bar: peak of elongation", 0.05),
                ("light bar: (S-E)/(S+E) of integrals", 0.5),
                ("light bar: peak of shortening", 0.05),
            )
        ),
        neuron="LGMD2",
    ),
    Row(
        13,
        "translation is answered only at first",
        "Disc of 10 deg over -40..40 deg; directions (largest - least)/largest, on the plain ground, where all fit.",
        selectivity.translation,
        (
            Line("peak at 60 deg/s", high=0.5),
            Line("from 500 ms on, by that peak", high=0.5),
            Line("peak, textured", high=0.5),
            Line("from 500 ms on, by that peak, textured", high=0.5),
            Line("spread of four directions", "%", high=5),
            Line("peak at 20 deg/s"),
            Line("peak at 200 deg/s"),
        ),
    ),
    Row(
        14,
        "adaptation acts on translation",
        "SMP before adaptation by the SMP after it; directions Peron & Gabbiani 2009.",
        selectivity.adaptation,
        (
            Line("without adaptation: integral of translation x", low=1.5, evidence="AP"),
            Line("without adaptation: peak of the loom x", high=1.15, evidence="AP"),
        ),
    ),
    Row(
        15,
        "faster is stronger",
        "Peaks of a disc that crosses 80 deg in 1,333 ms; and at constant speeds of 20, 40, 60, 100, 200 deg/s.",
        selectivity.speed,
        (
            Line("R: speed ~ t^2 above speed ~ t by", low=SAME, evidence="A"),
            Line("R: speed ~ t above constant by", low=-SAME, evidence="A"),
            Line("least step of R, 20..200 deg/s", low=-SAME),
        ),
    ),
    Row(
        16,
        "gratings are answered only at first",
        ".05, .1, .2 cyc/deg at 1, 4, 10 Hz as far as the eye samples them, Michelson 1 on 110; the worst of them.",
        field.gratings,
        (
            Line("mean R, 300..2,000 ms, at most", high=0.1),
            Line("peak in the first 300 ms, at most", high=0.35),
            Line("burst at the stop, at most"),
        ),
    ),
    Row(
        17,
        "changes of light",
        "Largest R from the onset to the end of the clip, up from 60 and down from 200, whole field and its quarter.",
        field.changes_of_light,
        tuple(Line(trials.change(*change), high=0.15) for change in trials.CHANGES),
    ),
    Row(
        18,
        "contrast",
        "Peak and angle at t_peak - D of the approach at 40 ms, Weber -.1 to -1.",
        looming.contrast,
        (
            Line("least step of R with |Weber|", low=-SAME),
            Line("R(-.9)/R(-1)", low=0.95, evidence="A"),
            Line("range of the angle at peak, -.3..-1", "deg", high=5, evidence="A"),
        ),
    ),
    Row(
        19,
        "all luminances halved",
        "10 on 100 instead of 20 on 200, approach at 40 ms.",
        looming.halved,
        (
            Line("change of the peak", "%", low=-15, high=15, evidence="DP"),
            Line("change of the angle at peak", "deg", low=-5, high=5),
        ),
    ),
    Row(
        20,
        "form and texture of the object",
        "A square, plain and of 4 x 4 checks of 20 and 110, against the disc of equal area, whose angle is stated.",
        looming.form,
        (
            Line("square: change of the angle at peak", "deg", low=-5, high=5, evidence="A"),
            Line("square: ratio of the peaks", low=0.8, high=1.25),
            Line("checks: change of the angle at peak", "deg", low=-5, high=5, evidence="A"),
            Line("checks: ratio of the peaks", low=0.8, high=1.25),
        ),
    ),
    Row(
        21,
        "what else moves, and near misses",
        'Loom over "gravel" of its own levels, drifting against still; and looms 0, 10, 20, 40 deg off the eye.',
        field.elsewhere,
        (
            Line("photograph drifting at 20 deg/s changes R by", high=-SAME, evidence="A"),
            Line("largest step of R with deviation", high=SAME, evidence="A"),
            Line("R straight on above R 40 deg off by", low=0.05),
            Line("half-width (animal 2..3)", "deg", evidence="A"),
        ),
    ),
    Row(
        22,
        "another frame rate",
        "The model at 200 fps (of 200 or more: at twice its own) against its own rate, l/|v| of 40, 50 and 80 ms.",
        looming.frame_rate,
        (Line("shift of the peak at 200 fps, at most", "ms", high=5),),
    ),
)
