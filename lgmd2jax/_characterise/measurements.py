"""From the curves of a model to its result."""

from collections.abc import Mapping
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Bool, Float

from lgmd2jax._characterise.curves import Curves
from lgmd2jax._characterise.exam import Exam
from lgmd2jax._characterise.panels import OVER, panels
from lgmd2jax._characterise.properties import ROWS
from lgmd2jax._characterise.result import Characterisation, Finding, JudgedAs
from lgmd2jax._characterise.selectivity import UNITS, Estimate, selectivity
from lgmd2jax._characterise.verdicts import Values, judge
from lgmd2jax._eye import Eye

_FAST_ENOUGH = 100.0  # frames per second, for edges not to jump
_TIMED = (1, 2, 3, 4, 5, 22)
_CROSSING = (12, 13, 15)  # rows of objects that move from -40 to 40 degrees
_SPAN = 80.0  # degrees


class Measurements(NamedTuple):
    """All that is read from curves, in one compiled function."""

    values: Values
    passed: Bool[Array, " row"]
    panels: Mapping[str, Float[Array | np.ndarray, " _place"]]
    selectivity: dict[str, Float[Array, ""]]
    r: tuple[Float[Array, "_trial _time"], ...]
    references: dict[bool, Float[Array, ""]]


def measure(curves: Curves) -> Measurements:
    """Values, verdicts, panels and summary."""
    return Measurements(*judge(curves), panels(curves), selectivity(curves), curves.adapted, curves.references)


def result_of(exam: Exam, neuron: JudgedAs, measurements: Measurements) -> Characterisation:
    """The result for the user; rows that the eye undersamples or that are not meant for the neuron are not judged."""
    measurements, remarks = jax.device_get(measurements), unjudged(exam.eye, neuron)
    findings = [
        Finding(
            row,
            tuple(float(value) for value in values),
            None if row.number in remarks else bool(holds),
            remarks.get(row.number, ""),
        )
        for row, values, holds in zip(ROWS, measurements.values, measurements.passed, strict=True)
    ]
    curves = {
        trial.name: (trial.time, np.asarray(curve))
        for group, some in zip(exam.groups, measurements.r, strict=True)
        for trial, curve in zip(group, some, strict=True)
    }
    return Characterisation(
        eye=exam.eye,
        neuron=neuron,
        reference=float(measurements.references[False]),
        reference_textured=float(measurements.references[True]),
        rows=tuple(findings),
        selectivity={name: Estimate(float(measurements.selectivity[name])) for name in UNITS},
        panels={name: np.asarray(measurements.panels[name]) for name in OVER},
        curves=curves,
    )


def unjudged(eye: Eye, neuron: JudgedAs) -> dict[int, str]:
    """Which rows are not judged, and why, by number."""
    remarks = {}
    if neuron == "LGMD1":
        remarks |= {row.number: "not meant" for row in ROWS if row.neuron == "LGMD2"}
    if eye.fps < _FAST_ENOUGH:
        remarks |= dict.fromkeys(_TIMED, "undersampled")
    if eye.field_of_view[1] < _SPAN:
        remarks |= dict.fromkeys(_CROSSING, "beyond field")
    return remarks
