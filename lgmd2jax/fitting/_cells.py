"""Cells of a report's tables: an interval, a unit, a share of the variance."""

import math

from lgmd2jax._reports.digits import rounded
from lgmd2jax.fitting._uncertainty.covariance import Uncertainty


def interval_cell(u: Uncertainty, i: int) -> str:
    """The interval of a parameter by its number, where there is one."""
    if u.reason:
        return "unknown"
    if not u.determined[i]:
        return "undetermined"
    return " .. ".join(rounded(float(end), float(u.values[i]), float(u.standard_errors[i])) for end in u.intervals[i])


def unit_cell(unit: str) -> str:
    """A unit; empty for a number without one."""
    return "" if unit == "1" else unit


def r2_cell(r2: float) -> str:
    """R2; a target that does not vary has none."""
    return "flat" if math.isnan(r2) else f"{r2:.3f}"
