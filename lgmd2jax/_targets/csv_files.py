"""Recorded curves and spike times, read from CSV files with a header."""

import os
import re
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from lgmd2jax._arguments.checked import checked
from lgmd2jax._arguments.units import Duration, size_of
from lgmd2jax._channels import Channel
from lgmd2jax._targets.columns import Columns, Where, read_columns
from lgmd2jax._targets.spike_trains import Likelihood, SpikeTrains
from lgmd2jax._targets.target import Target
from lgmd2jax._words import warn

_IN_BRACKETS = re.compile(r"[(\[]\s*([^()\[\]]+?)\s*[)\]]\s*$")
_LIKE_A_UNIT = re.compile(r"/|%|hz|\bm?v\b|volt|\bbins?\b|\bm?s\b", re.IGNORECASE)
_SMP = -5.0, 5.0  # farther than noise takes a potential of 0.5 to 1, nearer than percent and mV
_POOLED = 4  # trials for which the variance counts that all times share


@checked
def read_target(
    path: str | os.PathLike,
    *,
    column: str | Sequence[str],
    channel: Channel,
    sem: str | None = None,
    interpolate: bool = False,
    time: str | None = None,
    time_unit: str | None = None,
    unit: str | None = None,
    where: Where | None = None,
    separator: str | None = None,
    decimal: str = ".",
) -> Target:
    """A target from a column of a CSV file.

    **Arguments:**

    - `column`: by its name in the header. Of several, a column a trial, it is the mean, with its standard error.
    - `channel`, `interpolate`: as of `Target`.
    - `sem`: the column of the standard errors, where there is one.
    - `time`: the column of the times, by default the one named like a time, such as `time_ms`, `t` or `Time (s)`.
    - `time_unit`: `"ms"`, `"s"`, `"us"` or `"min"`; by default the one in the name of the column, else ms.
    - `unit`: of rates, by default the one in brackets in the name of the column, else `"spikes/s"`; or `"spikes/ms"` or
      `"kHz"`.
    - `where`: takes only rows in which columns hold these values, as `{"l_over_v": 20}`.
    - `separator`: of the cells, by default the one that divides all rows alike; `decimal`: the sign in numbers.

    **Raises:** `ValueError`, which names the file, for a column that is not there or there twice, for what is no finite
    number, where the time or the separator could be several, and as `Target`; `OSError` where it cannot be read.
    """
    names = [column] if isinstance(column, str) else column
    try:
        if not names:
            raise ValueError(f"column is {column!r}; give a name of the header, or a tuple of names")
        factors = [_factor(name, unit, channel) for name in [*names, *([sem] if sem else [])]]
        table = read_columns(path, separator, decimal).where(where)
        clock, ms = table.time(time, time_unit, [*names, *(where or ()), *([sem] if sem else [])])
        times = ms * table.numbers(clock)
        _check_one_curve(table, times, [clock, *names, *(where or ()), *([sem] if sem else [])])
        trials = np.stack([factor * table.numbers(name) for name, factor in zip(names, factors, strict=False)])
        _warn_of_values(path, channel, trials)
        errors, rule = None if sem is None else factors[-1] * table.numbers(sem), ""
        if sem is None and len(trials) > 1:
            errors, rule = _standard_error(trials)
        return Target(channel, trials.mean(axis=0), time=times, sem=errors, interpolate=interpolate, sem_rule=rule)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


@checked
def read_spike_trains(
    path: str | os.PathLike,
    *,
    kernel_ms: Duration = 20.0,
    likelihood: Likelihood = "normal",
    animal: str = "animal",
    trial: str = "trial",
    time: str | None = None,
    time_unit: str | None = None,
    columns: Sequence[str] | None = None,
    where: Where | None = None,
    separator: str | None = None,
    decimal: str = ".",
) -> SpikeTrains:
    """Spike trains from a CSV file with a row a spike, or with a column a trial.

    A row without a time is a trial without spikes.

    **Arguments:**

    - `kernel_ms`, `likelihood`: as of `SpikeTrains`.
    - `animal`, `trial`: names of columns.
    - `columns`: names of columns that hold the spike times of one trial each, all of one animal; there is then no
      column of animals, trials and times. Empty cells below the last spike are passed over.
    - `time`, `time_unit`, `where`, `separator`, `decimal`: as of `read_target`.

    **Raises:** `ValueError`, which names the file, as `read_target` and `SpikeTrains`; `OSError` where it cannot be
    read. Warns of a further column, such as one of stimuli, whose values would be read as one recording.
    """
    try:
        table = read_columns(path, separator, decimal).where(where)
        if columns is not None:
            ms = 1.0 if time_unit is None else size_of(time_unit, "ms")
            if ms is None:
                raise ValueError(f"time_unit is {time_unit!r}; give 'ms', 's', 'us' or 'min'")
            return SpikeTrains([[_spikes(table, name, ms) for name in columns]], kernel_ms, likelihood)
        clock, ms = table.time(time, time_unit, [animal, trial, *(where or ())])
        trains: dict[str, dict[str, list[float]]] = {}
        cells = zip(table.text(animal), table.text(trial), table.numbered(clock), strict=True)
        for who, which, (number, when) in cells:
            if not (who and which):
                raise ValueError(f"row {number} lacks its {animal if not who else trial}")
            spikes = trains.setdefault(who, {}).setdefault(which, [])
            if when:
                spikes.append(ms * table.number(when, clock, number))
        _warn_of_conditions(path, table, (animal, trial), [clock, *(where or ())])
        return SpikeTrains([list(trials.values()) for trials in trains.values()], kernel_ms, likelihood, list(trains))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _factor(column: str, unit: str | None, channel: Channel) -> float:
    """What a value of a column is multiplied by, for its unit: the one given, or that in brackets in its name."""
    own = _IN_BRACKETS.search(column)
    kind = "Hz" if channel == "rate" else "1"
    factor = 1.0 if unit is None else size_of(unit, kind)
    if factor is None:
        raise ValueError(f"unit is {unit!r}, which is none of the channel {channel!r}")
    if own is None:
        return factor
    named = size_of(own[1], kind)
    if named is None:
        if unit is None and _LIKE_A_UNIT.search(own[1]):
            raise ValueError(
                f"column {column!r} has the unit {own[1]!r}, which is none of the channel {channel!r}; convert it, or "
                "give its true unit"
            )
        return factor
    if unit is not None and named != factor:
        raise ValueError(f"unit is {unit!r}, but the column is named {column!r}; correct one of them")
    return named


def _warn_of_values(path: str | os.PathLike, channel: Channel, values: np.ndarray) -> None:
    """Warn of a potential that is none of 0.5 to 1, by far."""
    low, high = float(values.min()), float(values.max())
    if channel.startswith("smp") and not (_SMP[0] <= low and high <= _SMP[1]):
        warn(
            f"{path}: the values of {channel!r} reach from {low:g} to {high:g}, and the potential lies in 0.5 to 1; "
            "convert percent or mV first"
        )


def _spikes(table: Columns, name: str, ms: float) -> list[float]:
    return [ms * table.number(cell, name, row) for row, cell in table.numbered(name) if cell]


def _standard_error(trials: np.ndarray) -> tuple[np.ndarray, str]:
    """Of the mean over trials; the variance of few is drawn towards that which all times share."""
    count = len(trials)
    variance = np.var(trials, axis=0, ddof=1)
    drawn = ((count - 1) * variance + _POOLED * variance.mean()) / (count - 1 + _POOLED)
    if not drawn.any():
        raise ValueError("the trials are all equal, so that no standard error follows; name one of them as the column")
    return np.sqrt(drawn / count), f"s.e.m. over {count} trials, drawn towards one that all times share"


def _check_one_curve(table: Columns, times: np.ndarray, used: Collection[str]) -> None:
    """Refuse a file that holds several curves below each other, of which none is chosen."""
    if np.all(np.diff(times) > 0):
        return
    others = _told_apart_by(table, [name for name in table.header if name not in used])
    if others:
        name, values = next(iter(others.items()))
        raise ValueError(
            f"times come again, and column {name!r} holds {_some(values)}; choose one curve by "
            f"where = {{ {name} = {values[0]} }}"
        )


def _warn_of_conditions(path: str | os.PathLike, table: Columns, trial: tuple[str, str], used: Collection[str]) -> None:
    """Warn of a column that says more of a whole trial than animal and number, such as which stimulus was some."""
    groups = list(zip(*(table.text(name) for name in trial), strict=True))
    others = _told_apart_by(table, [name for name in table.header if name not in (*trial, *used)])
    for name, values in others.items():
        pairs = list(zip(groups, table.text(name), strict=True))
        if len(set(pairs)) < len(pairs):  # a value comes again within a trial: no number of a spike, no amplitude
            warn(
                f"{path}: column {name!r} holds {_some(values)}, all of which are read as one recording; choose one by "
                f"where = {{ {name} = {values[0]} }}"
            )


def _told_apart_by(table: Columns, names: Sequence[str]) -> Mapping[str, tuple[str, ...]]:
    """The columns with more than one value, and these."""
    values = {name: tuple(dict.fromkeys(table.text(name))) for name in names if table.header.count(name) == 1}
    return {name: different for name, different in values.items() if len(different) > 1}


def _some(values: tuple[str, ...]) -> str:
    some = ", ".join(map(repr, values[:4]))
    return f"{len(values)} values ({some}{', ...' if len(values) > 4 else ''})"
