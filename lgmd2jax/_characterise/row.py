"""What a row of the exam is: a response property, told by lines, each a value with its bounds, read from curves."""

import dataclasses
import functools
import math
import operator
from collections.abc import Callable, Iterable, Sequence
from typing import Literal

import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._characterise.curves import Curves

Neuron = Literal["LGMD2", "any LGMD"]
EVIDENCE = {
    "A": "stated in the primary paper or its abstract",
    "D": "computed from public recordings",
    "M": "from a published model's code",
    "S": "second-hand",
    "P": "this project's choice",
}
SAME = 1e-3  # of R; smaller differences are none


@dataclasses.dataclass(frozen=True)
class Line:
    """One value of a row: what it is, its unit, where it must lie (ends included), and on what evidence.

    A line without bounds is printed and not judged.
    """

    label: str
    unit: str = ""
    low: float | int = -math.inf
    high: float | int = math.inf
    evidence: str = "P"

    @property
    def judged(self) -> bool:
        """Whether there is a bound."""
        return math.isfinite(self.low) or math.isfinite(self.high)

    @property
    def bound(self) -> str:
        """In words; empty where there is none."""
        if math.isfinite(self.low) and math.isfinite(self.high):
            return f"{self.low:g}..{self.high:g}"
        if math.isfinite(self.low):
            return f">= {self.low:g}"
        return f"<= {self.high:g}" if math.isfinite(self.high) else ""

    def holds(self, value: Array | np.floating | float) -> Array | np.bool_ | bool:
        """Whether a value lies within the bounds; NaN does not."""
        return (value >= self.low) & (value <= self.high)


@dataclasses.dataclass(frozen=True)
class Row:
    """A response property.

    - `definition`: what is measured, for users.
    - `measure`: reads the values of the lines from curves.
    - `neuron`: which neuron has the property.
    - `holds_if`: which of the lines must hold.
    """

    number: int
    name: str
    definition: str
    measure: Callable[[Curves], Sequence[Float[Array, ""]]]
    lines: tuple[Line, ...]
    neuron: Neuron = "any LGMD"
    holds_if: Literal["all lines hold", "any line holds"] = "all lines hold"

    def holds(self, values: Iterable) -> Array | np.bool_ | bool:
        """Whether the property holds by these values of the lines; NaN holds nowhere."""
        verdicts = [line.holds(value) for line, value in zip(self.lines, values, strict=True) if line.judged]
        return functools.reduce(operator.or_ if self.holds_if == "any line holds" else operator.and_, verdicts)
