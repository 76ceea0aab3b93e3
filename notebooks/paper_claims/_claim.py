"""A claim of the paper, where it is made, and what measuring it finds."""

import dataclasses
import itertools
from collections.abc import Callable, Mapping
from typing import Any


@dataclasses.dataclass(frozen=True)
class Finding:
    """What was measured, in words, and whether each statement of the claim holds."""

    measured: str
    statements: Mapping[str, bool]

    @property
    def failing(self) -> tuple[str, ...]:
        """The statements that do not hold."""
        return tuple(statement for statement, holds in self.statements.items() if not holds)

    @property
    def verdict(self) -> str:
        """What the table says: yes, no, or what does not hold."""
        if not self.statements:
            return "not yet"
        if not self.failing:
            return "yes"
        return "no" if len(self.failing) == len(self.statements) else f"in part; not: {', '.join(self.failing)}"


@dataclasses.dataclass(frozen=True)
class Claim:
    """One sentence of the paper.

    - `measure`: shows the stimuli to the networks. Without arguments, with Table I and the shipped protocols.
    - `choices`: what the paper leaves open, by name: arguments of `measure` that choose otherwise.
    """

    number: int
    where: str
    text: str
    measure: Callable[..., Finding]
    choices: Mapping[str, Mapping[str, Any]]


CLAIMS: dict[int, Claim] = {}


def claim(number: int, where: str, text: str, choices: Mapping[str, Mapping[str, Any]] | None = None):
    """Enter a function that measures a claim under its number."""

    def enter(measure: Callable[..., Finding]) -> Callable[..., Finding]:
        CLAIMS[number] = Claim(number, where, text, measure, choices or {})
        return measure

    return enter


def listed(values, digits: int = 3) -> str:
    """Numbers in a row: .937, .912, .845."""
    return ", ".join(f"{value:.{digits}f}" for value in values)


def shares(values) -> str:
    """Shares in a row: 100%, 80%."""
    return ", ".join(f"{value:.0%}" for value in values)


def spread(pairs, digits: int = 3) -> str:
    """Means with their standard deviations in a row: .937 +- .002, .912 +- .010."""
    return ", ".join(f"{mean:.{digits}f} +- {deviation:.{digits}f}" for mean, deviation in pairs)


def rises(values) -> bool:
    """Each is larger than the one before."""
    return all(a < b for a, b in itertools.pairwise(values))


def falls(values) -> bool:
    """Each is smaller than the one before."""
    return rises(values[::-1])
