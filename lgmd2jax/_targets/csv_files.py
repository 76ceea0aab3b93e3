"""Recorded curves and spike times, read from CSV files with a header."""

import csv
import math
import os

import numpy as np

from lgmd2jax._channels import Channel
from lgmd2jax._targets.spike_trains import SpikeTrains
from lgmd2jax._targets.target import Target
from lgmd2jax._words import nearest


def read_target(
    path: str | os.PathLike, *, column: str, channel: Channel, sem: str | None = None, interpolate: bool = False
) -> Target:
    """A target from a column of a CSV file, whose first column is the time in ms.

    **Arguments:** `column`, and `sem` where there are standard errors, by their names in the header; `channel` and
    `interpolate` as of `Target`.

    **Raises:** `ValueError`, which names the file, for a column that is not there, for what is no finite number, and as
    `Target`; `OSError` where it cannot be read.
    """
    try:
        table = _read(path)
        clock, *_ = table
        errors = None if sem is None else _numbers(table, sem)
        values = _numbers(table, column)
        return Target(channel, values, time=_numbers(table, clock), sem=errors, interpolate=interpolate)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def read_spike_trains(
    path: str | os.PathLike,
    *,
    kernel_ms: float | int = 20.0,
    animal: str = "animal",
    trial: str = "trial",
    time: str = "time_ms",
) -> SpikeTrains:
    """Spike trains from a CSV file with a row a spike; a row without a time is a trial without spikes.

    **Arguments:** `kernel_ms` as of `SpikeTrains`; `animal`, `trial` and `time` are names in the header.

    **Raises:** `ValueError`, which names the file, for a column that is not there, for times that are no finite
    numbers, and as `SpikeTrains`; `OSError` where it cannot be read.
    """
    try:
        table = _read(path)
        rows = zip(*(_column(table, name) for name in (animal, trial, time)), strict=True)
        trains: dict[str, dict[str, list[float]]] = {}
        for number, (who, which, when) in enumerate(rows, start=1):
            if not (who and which):
                raise ValueError(f"row {number} lacks its {animal if not who else trial}")
            spikes = trains.setdefault(who, {}).setdefault(which, [])
            if when:
                spikes.append(_number(when, time, number))
        return SpikeTrains([list(trials.values()) for trials in trains.values()], kernel_ms)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _read(path: str | os.PathLike) -> dict[str, list[str]]:
    """The columns of a CSV file as text, by name."""
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            header, *rows = [line for line in csv.reader(file, strict=True) if line] or [[]]
    except (csv.Error, UnicodeDecodeError) as error:
        raise ValueError(f"not a CSV file: {error}") from error
    if not rows:
        raise ValueError("no rows; give a header and a row for each time")
    for number, row in enumerate(rows, start=1):
        if len(row) != len(header):
            raise ValueError(f"row {number} has {len(row)} cells and the header {len(header)}; make them equal")
    return {name.strip(): [row[place].strip() for row in rows] for place, name in enumerate(header)}


def _column(table: dict[str, list[str]], name: str) -> list[str]:
    if name not in table:
        raise ValueError(f"no column {name!r}; choose {nearest(name, table)}")
    return table[name]


def _numbers(table: dict[str, list[str]], name: str) -> np.ndarray:
    return np.array([_number(text, name, number) for number, text in enumerate(_column(table, name), start=1)])


def _number(text: str, name: str, row: int) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"column {name!r} holds {text!r} in row {row}, which is no finite number; leave such rows out")
    return value
