"""Bounds of a parameter, and the scale on which a fit measures between them."""

import dataclasses
import math
from typing import Any, Literal

from lgmd2jax._arguments.checked import checked


@dataclasses.dataclass(frozen=True)
class Range:
    """Bounds of one parameter; a bound that is None is the one declared with the parameter.

    - `prior`: mean and standard deviation of what is known beforehand, in the parameter's unit; it acts as a penalty
      beside data whose errors are known.
    """

    low: float | int | None = None
    high: float | int | None = None
    prior: tuple[float | int, float | int] | None = None


@checked
class Linear(Range):
    """Bounds between which a fit measures differences: `Linear(1, 6)`, the same as the pair `(1, 6)`."""


@checked
class Log(Range):
    """Bounds between which a fit measures factors: `Log(5, 50)`. Both bounds are positive."""


Scale = Literal["linear", "log"]
RANGES = {"linear": Linear, "log": Log}


def between(low: Any, high: Any, scale: Scale, z: Any) -> Any:
    """The value at z in [0, 1] between bounds."""
    return low * (high / low) ** z if scale == "log" else low + (high - low) * z


def check_bounds(name: str, low: float | int, high: float | int, scale: Scale) -> None:
    """Raise `ValueError` for bounds between which there is no such scale."""
    if not low < high:
        raise ValueError(f"{name} has the bounds {low:g} and {high:g}; the first must be below the second")
    if not (math.isfinite(low) and math.isfinite(high)):
        raise ValueError(f"{name} has the bounds {low:g} and {high:g}; give finite ones")
    if scale == "log" and low <= 0:
        raise ValueError(f"{name} has the bound {low:g}; bounds on a logarithmic scale must be positive")
