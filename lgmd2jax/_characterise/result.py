"""What the exam measured on a model: as data, as JSON, and as text, models side by side."""

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Literal

import numpy as np
from jaxtyping import Float

from lgmd2jax._characterise.row import EVIDENCE, Row
from lgmd2jax._characterise.selectivity import UNITS, Estimate
from lgmd2jax._eye import Eye

JudgedAs = Literal["LGMD2", "LGMD1"]

_LABEL, _BOUND, _COLUMN = 50, 9, 12  # widths of the table


@dataclasses.dataclass(frozen=True)
class Finding:
    """One of the 22 properties, measured on one model.

    - `row`: the property itself, with its definition and its criteria.
    - `values`: what was measured for each criterion, in its unit; NaN where there is nothing to measure, as of a silent
      cell.
    - `passed`: whether the property holds; None where it is not judged, for the reason in `remark`.
    """

    row: Row
    values: tuple[float, ...]
    passed: bool | None
    remark: str = ""

    @property
    def number(self) -> int:
        """The number of the property, 1 to 22."""
        return self.row.number

    @property
    def name(self) -> str:
        """The name of the property."""
        return self.row.name

    @property
    def verdict(self) -> str:
        """The verdict in a word: `"pass"`, `"FAIL"`, or the remark."""
        return self.remark or ("pass" if self.passed else "FAIL")

    def plain(self) -> dict[str, Any]:
        """All as plain data for JSON, None for what is not finite."""
        lines = [
            dataclasses.asdict(line) | {"bound": line.bound, "value": value}
            for line, value in zip(self.row.lines, self.values, strict=True)
        ]
        whole = {
            "number": self.number,
            "name": self.name,
            "definition": self.row.definition,
            "neuron": self.row.neuron,
            "passed": self.passed,
            "remark": self.remark,
            "holds_if": self.row.holds_if,
        }
        return whole | {"lines": [{name: _finite(value) for name, value in line.items()} for line in lines]}


@dataclasses.dataclass(frozen=True)
class Characterisation:
    """The 22 response properties of a model.

    ```python
    found = lgmd.characterise(lgmd.load_fit("lgmd2"))
    print(found)                      # the table
    found[3].passed, found[3].values  # property 3
    ```

    R is a response above rest as a share of the peak that the same model has for a dark loom at l/|v| 40 ms.

    - `eye`: for which the stimuli were rendered. `neuron`: what the model is judged as: `"LGMD2"`, or `"LGMD1"` where
      its ON pathway weighs at least half as much as the OFF pathway, or where it has none.
    - `reference`, `reference_textured`: that peak, in units of SMP, on a plain and on a textured ground; below .05 no R
      is given.
    - `rows`: a `Finding` for each property, in the order of their numbers.
    - `selectivity`: six numbers by which papers sum it up, by name, with intervals where a covariance is known.
    - `panels`: values over conditions, as the figure shows them.
    - `curves`: time in ms and R for every stimulus by name.
    """

    eye: Eye
    neuron: JudgedAs
    reference: float
    reference_textured: float
    rows: tuple[Finding, ...]
    selectivity: Mapping[str, Estimate]
    panels: Mapping[str, Float[np.ndarray, " _place"]]
    curves: Mapping[str, tuple[Float[np.ndarray, " _time"], Float[np.ndarray, " _time"]]]

    def __getitem__(self, number: int) -> Finding:
        """The property of a number, 1 to 22."""
        return self.rows[number - 1]

    @property
    def passed(self) -> int:
        """How many properties hold."""
        return sum(finding.passed is True for finding in self.rows)

    @property
    def judged(self) -> int:
        """How many properties have a verdict."""
        return sum(finding.passed is not None for finding in self.rows)

    def __repr__(self):
        return self.summary()

    def summary(self) -> str:
        """The table as text: a row for each property and each of its criteria, and the selectivity."""
        return table({"value": self})

    def plain(self) -> dict[str, Any]:
        """All but the curves as plain data for JSON."""
        return {
            "eye": dataclasses.asdict(self.eye),
            "neuron": self.neuron,
            "reference": self.reference,
            "reference_textured": self.reference_textured,
            "passed": self.passed,
            "judged": self.judged,
            "rows": [finding.plain() for finding in self.rows],
            "selectivity": {
                name: {"unit": UNITS[name]} | {part: _finite(value) for part, value in estimate._asdict().items()}
                for name, estimate in self.selectivity.items()
            },
            "panels": {name: [_finite(float(value)) for value in values] for name, values in self.panels.items()},
        }


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def table(models: Mapping[str, Characterisation]) -> str:
    """Rows with their verdicts, lines with their values, and the summary of selectivity; a column for each model."""
    return "\n".join(_lines(models)).rstrip()


def _lines(models: Mapping[str, Characterisation]) -> Iterator[str]:
    results, wide = list(models.values()), max(_COLUMN, *map(len, models))

    def line(label: str, cells: Iterable[str], bound: str = "", evidence: str = "") -> str:
        return f"{label:<{_LABEL}} {bound:>{_BOUND}} {evidence:<10}" + "".join(f"  {cell:>{wide}}" for cell in cells)

    yield line("property", models, "bound", "[evidence]")
    yield "-" * (_LABEL + _BOUND + 11 + (wide + 2) * len(results))
    for findings in zip(*(result.rows for result in results), strict=True):
        row = findings[0].row
        target = " (LGMD2)" if row.neuron == "LGMD2" else ""
        yield line(f"{row.number:2} {row.name}{target}", (finding.verdict for finding in findings))
        for i, each in enumerate(row.lines):
            label = f"     {each.label}" + (f", {each.unit}" if each.unit else "")
            evidence = "".join(f"[{letter}]" for letter in each.evidence) if each.judged else ""
            yield line(label, (number(finding.values[i]) for finding in findings), each.bound, evidence)
    yield ""
    yield line(
        "properties that hold, of those evaluated", (f"{result.passed} of {result.judged}" for result in results)
    )
    reference = "R = 1: peak of the dark loom at 40 ms, SMP"
    yield line(reference, (number(result.reference) for result in results), ">= 0.05")
    yield line("     textured", (number(result.reference_textured) for result in results), ">= 0.05")
    yield line("evaluated as", (result.neuron for result in results))
    yield line("eye", (f"{result.eye.rows} x {result.eye.cols}" for result in results))
    yield line("     degrees a pixel", (f"{result.eye.degrees_per_pixel:g}" for result in results))
    yield line("     frames per second", (f"{result.eye.fps:g}" for result in results))
    yield ""
    have_intervals = any(_interval(estimate) for result in results for estimate in result.selectivity.values())
    yield "selectivity" + (" (interval at 95 %)" if have_intervals else "")
    for name, unit in UNITS.items():
        estimates = [result.selectivity[name] for result in results]
        label = f"     {name}" + ("" if unit == "1" else f", {unit}")
        yield line(label, (number(estimate.value) for estimate in estimates))
        if have_intervals:
            yield line("", map(_interval, estimates))
    yield ""
    yield "evidence: " + "; ".join(f"[{letter}] {meaning}" for letter, meaning in EVIDENCE.items())


def number(value: float) -> str:
    """Three digits; a dash for what was not to be measured."""
    if math.isnan(value):
        return "-"
    return f"{0.0 if abs(value) < 5e-5 else value:.3g}"


def _interval(estimate: Estimate) -> str:
    return "" if math.isnan(estimate.low) else f"{number(estimate.low)}..{number(estimate.high)}"
