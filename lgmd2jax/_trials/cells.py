"""Values of other programs as the cells of a table."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from lgmd2jax._targets.columns import Columns


def table_of(header: Sequence[Any], rows: Sequence[Sequence[Any]], first_row: int = 1) -> Columns:
    """A table as if it had been read from a text file.

    **Arguments:** `first_row`: the number of the first row, in messages.
    """
    cells = tuple(tuple(cell_of(value) for value in row) for row in rows)
    numbers = tuple(range(first_row, first_row + len(cells)))
    return Columns(tuple(map(cell_of, header)), cells, numbers, "", ".")


def cell_of(value: Any) -> str:
    """A value as text, a missing one as an empty cell."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, np.ndarray):
        value = value.item() if value.size == 1 else ""
    if isinstance(value, (bool, np.bool_)):
        return str(bool(value))
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    return str(value).strip()
