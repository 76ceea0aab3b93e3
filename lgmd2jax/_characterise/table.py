"""The exam as text: a row of the table for each line of a row, a column for each model."""

import math
from collections.abc import Iterator, Mapping

from lgmd2jax._characterise.result import Characterisation
from lgmd2jax._characterise.row import EVIDENCE
from lgmd2jax._characterise.selectivity import UNITS, Estimate

_LABEL, _BOUND, _COLUMN = 50, 9, 12


def table(models: Mapping[str, Characterisation]) -> str:
    """Rows with their verdicts, lines with their values, and the summary of selectivity."""
    wide = max(_COLUMN, *(len(name) for name in models))
    return "\n".join(_lines(models, wide)).rstrip()


def _lines(models: Mapping[str, Characterisation], wide: int) -> Iterator[str]:
    found = list(models.values())
    yield _line("property", "bound", "[evidence]", models, wide)
    yield "-" * (_LABEL + _BOUND + 11 + (wide + 2) * len(found))
    for row, *findings in zip(found[0].rows, *(it.rows for it in found), strict=True):
        target = " (LGMD2)" if row.row.neuron == "LGMD2" else ""
        yield _line(f"{row.number:2} {row.name}{target}", "", "", (it.verdict for it in findings), wide)
        for i, line in enumerate(row.row.lines):
            evidence = "".join(f"[{letter}]" for letter in line.evidence) if line.judged else ""
            label = f"     {line.label}" + (f", {line.unit}" if line.unit else "")
            yield _line(label, line.bound, evidence, (number(it.values[i]) for it in findings), wide)
    yield ""
    yield _line("properties that hold, of those judged", "", "", (f"{it.passed} of {it.judged}" for it in found), wide)
    for label, field in (
        ("R = 1: peak of the dark loom at 40 ms, SMP", "reference"),
        ("     textured", "reference_textured"),
    ):
        yield _line(label, ">= 0.05", "", (number(getattr(it, field)) for it in found), wide)
    yield _line("judged as", "", "", (it.neuron for it in found), wide)
    yield _line("eye", "", "", (f"{it.eye.rows} x {it.eye.cols}" for it in found), wide)
    yield _line("     degrees a pixel", "", "", (f"{it.eye.degrees_per_pixel:g}" for it in found), wide)
    yield _line("     frames per second", "", "", (f"{it.eye.fps:g}" for it in found), wide)
    yield ""
    yield "selectivity" + (" (interval at 95 %)" if any(_known(it) for it in found) else "")
    for name, unit in UNITS.items():
        label = f"     {name}" + ("" if unit == "1" else f", {unit}")
        yield _line(label, "", "", (number(it.selectivity[name].value) for it in found), wide)
        if any(_known(it) for it in found):
            yield _line("", "", "", (_interval(it.selectivity[name]) for it in found), wide)
    yield ""
    yield "evidence: " + "; ".join(f"[{letter}] {meaning}" for letter, meaning in EVIDENCE.items())


def number(value: float) -> str:
    """Three digits; a dash for what was not to be measured."""
    if math.isnan(value):
        return "-"
    return f"{0.0 if abs(value) < 5e-5 else value:.3g}"


def _known(it: Characterisation) -> bool:
    return any(not math.isnan(estimate.low) for estimate in it.selectivity.values())


def _interval(it: Estimate) -> str:
    return "" if math.isnan(it.low) else f"{number(it.low)}..{number(it.high)}"


def _line(label, bound, evidence, cells, wide: int) -> str:
    return f"{label:<{_LABEL}} {bound:>{_BOUND}} {evidence:<10}" + "".join(f"  {cell:>{wide}}" for cell in cells)
