"""The curve that a condition's response is compared with."""

import csv
import os

import equinox as eqx
import numpy as np
from jaxtyping import Float


class Target(eqx.Module):
    """A recorded rate at the frames of a stimulus.

    - `values`: spikes/s.
    - `sem`: its standard error, where it is known, else None.
    - `weight`: 1 where the recording covers the frame, else 0.
    """

    values: Float[np.ndarray, " time"]
    sem: Float[np.ndarray, " time"] | None
    weight: Float[np.ndarray, " time"]


def read_target(
    path: str | os.PathLike, column: str, time: Float[np.ndarray, " time"], sem: str | None = None
) -> Target:
    """A column of a CSV file, interpolated onto the frame times. The first column is the time in ms.

    **Raises:** `ValueError` for a column that is not there, for values that are no finite numbers, and for times that
    do not increase; `OSError` where the file cannot be read.
    """
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        raise ValueError(f"{path} holds no rows; give a CSV file with a header and a row for each time")
    clock = next(iter(rows[0]))

    def numbers(name: str) -> np.ndarray:
        if name not in rows[0]:
            raise ValueError(f"{path} has no column {name!r}; there are {', '.join(rows[0])}")
        try:
            values = np.array([float(row[name]) for row in rows])
        except (TypeError, ValueError):
            values = np.array([np.nan])
        if not np.isfinite(values).all():
            raise ValueError(f"{path}: column {name!r} holds what is not a finite number; leave such rows out")
        return values

    times = numbers(clock)
    if not np.all(np.diff(times) > 0):
        raise ValueError(f"{path}: the times in column {clock!r} do not increase; sort the rows")
    errors = None if sem is None else np.interp(time, times, numbers(sem))
    covered = (time >= times[0]) & (time <= times[-1])
    return Target(np.interp(time, times, numbers(column)), errors, covered.astype(float))
