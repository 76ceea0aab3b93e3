"""Bounds of a parameter, and the scale on which a fit measures between them."""

import dataclasses
import math
from typing import Any, Literal

from lgmd2jax._arguments.checked import checked


@dataclasses.dataclass(frozen=True)
class Range:
    """Bounds of one parameter, and perhaps a prior."""

    low: float | int | None = None
    high: float | int | None = None
    prior: tuple[float | int, float | int] | None = None


@checked
class Linear(Range):
    """Bounds of a free parameter on a linear scale: `Linear(1, 6)`, the same as the pair `(1, 6)`.

    The search then spreads its points evenly between the bounds.

    **Arguments:**

    - `low`, `high`: in the parameter's unit; None for the bound that is declared with the parameter.
    - `prior`: mean and standard deviation of what is known beforehand, in the parameter's unit. It adds a penalty, and
      needs targets whose errors are known.
    """


@checked
class Log(Range):
    """Bounds of a free parameter on a logarithmic scale: `Log(5, 50)`, for what is a matter of factors.

    **Arguments:** as of `Linear`; both bounds are positive.
    """


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
