"""What an exam found on one model."""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from jaxtyping import Float

from lgmd2jax._characterise.row import Row
from lgmd2jax._characterise.selectivity import UNITS, Estimate
from lgmd2jax._eye import Eye

JudgedAs = Literal["LGMD2", "LGMD1"]


@dataclasses.dataclass(frozen=True)
class Finding:
    """A row of the exam on one model.

    - `values`: of the row's lines, in their units; NaN where there is nothing to measure, as of a silent cell.
    - `passed`: None where it is not judged, for the reason in `remark`.
    """

    row: Row
    values: tuple[float, ...]
    passed: bool | None
    remark: str = ""

    @property
    def number(self) -> int:
        """Of the row, 1 to 22."""
        return self.row.number

    @property
    def name(self) -> str:
        """Of the property."""
        return self.row.name

    @property
    def verdict(self) -> str:
        """In a word."""
        return self.remark or ("pass" if self.passed else "FAIL")

    def plain(self) -> dict[str, Any]:
        """As JSON holds it: None for what is not finite."""
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
            "holds_if": "any line holds" if self.row.any_of else "all lines hold",
        }
        return whole | {"lines": [{name: _finite(value) for name, value in line.items()} for line in lines]}


@dataclasses.dataclass(frozen=True)
class Characterisation:
    """The 22 response properties of a model.

    - `eye`: that was shown them. `neuron`: what the model is judged as: `"LGMD2"`, or `"LGMD1"` where its ON pathway
      weighs at least half as much as the OFF pathway, or where it has none.
    - `reference`, `reference_textured`: the peak above rest, in units of SMP, of the dark loom at 40 ms by which R is
      normalised; below .05 there is no R.
    - `rows`: a `Finding` each, in the order of their numbers.
    - `selectivity`: the summary that the field uses, by name, with intervals where a covariance is known.
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
        """The row of a number."""
        return self.rows[number - 1]

    @property
    def passed(self) -> int:
        """How many rows hold."""
        return sum(it.passed is True for it in self.rows)

    @property
    def judged(self) -> int:
        """How many rows have a verdict."""
        return sum(it.passed is not None for it in self.rows)

    def __repr__(self):
        return self.summary()

    def summary(self) -> str:
        """The table."""
        from lgmd2jax._characterise.table import table

        return table({"value": self})

    def plain(self) -> dict[str, Any]:
        """As JSON holds it."""
        return {
            "eye": dataclasses.asdict(self.eye),
            "neuron": self.neuron,
            "reference": self.reference,
            "reference_textured": self.reference_textured,
            "passed": self.passed,
            "judged": self.judged,
            "rows": [it.plain() for it in self.rows],
            "selectivity": {
                name: {"unit": UNITS[name]} | {part: _finite(value) for part, value in it._asdict().items()}
                for name, it in self.selectivity.items()
            },
            "panels": {name: [_finite(float(value)) for value in values] for name, values in self.panels.items()},
        }


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
