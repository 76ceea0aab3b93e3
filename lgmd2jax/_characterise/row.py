"""What a row of the exam is: lines, each a value with its bounds, read from curves."""

import dataclasses
import math
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


@dataclasses.dataclass(frozen=True)
class Row:
    """A response property: it holds where all of its lines do, or any of them."""

    number: int
    name: str
    definition: str
    lines: tuple[Line, ...]
    measure: Callable[[Curves], Sequence[Float[Array, ""]]]
    neuron: Neuron = "any LGMD"
    any_of: bool = False

    def passed(self, values: Iterable) -> Array | np.bool_:
        """Whether these values of the lines hold; NaN holds nowhere."""
        held = [
            (value >= line.low) & (value <= line.high)
            for line, value in zip(self.lines, values, strict=True)
            if line.judged
        ]
        total = held[0]
        for one in held[1:]:
            total = total | one if self.any_of else total & one
        return total


def row(number: int, name: str, *lines: Line, neuron: Neuron = "any LGMD", any_of: bool = False):
    """Make a row of the function that reads the values of its lines from curves; its docstring is the definition."""

    def made(measure: Callable[[Curves], Sequence[Float[Array, ""]]]) -> Row:
        return Row(number, name, (measure.__doc__ or "").strip(), lines, measure, neuron, any_of)

    return made
