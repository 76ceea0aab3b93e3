"""What the cell did over a clip, as a table: a row a frame, and its columns."""

import array
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from lgmd2jax._signals import stretches


class Row(NamedTuple):
    """A line of the CSV file. `frame` counts the frames of the file from 0, repeated ones as well."""

    frame: int
    time_ms: float
    mp: float
    ffi: float
    smp: float
    smp_adapted: float
    spikes: int
    collision: int


class Trace(NamedTuple):
    """The columns of the CSV file."""

    frame: Int[np.ndarray, " time"]
    time_ms: Float[np.ndarray, " time"]
    mp: Float[np.ndarray, " time"]
    ffi: Float[np.ndarray, " time"]
    smp: Float[np.ndarray, " time"]
    smp_adapted: Float[np.ndarray, " time"]
    spikes: Int[np.ndarray, " time"]
    collision: Int[np.ndarray, " time"]

    def alarms(self) -> list[tuple[int, int]]:
        """First and last row of every stretch in which the alarm is on."""
        return stretches(self.collision > 0)


class Rows:
    """Rows as they come, in 64 bytes each: a clip may be hours long."""

    def __init__(self):
        self._numbers = array.array("d")

    def append(self, row: Row) -> None:
        """Add the next row."""
        self._numbers.extend(row)

    def trace(self) -> Trace:
        """The columns of all rows."""
        columns = dict(zip(Row._fields, np.array(self._numbers).reshape(-1, len(Row._fields)).T, strict=True))
        counts = {name: columns[name].astype(int) for name in ("frame", "spikes", "collision")}
        return Trace(**(columns | counts))
