"""Trials from NWB files: spike times of a unit, cut by the table of trials (the extra `nwb`)."""

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lgmd2jax._compute.cluster import need
from lgmd2jax._trials.cells import table_of
from lgmd2jax._trials.header import ROLES, split
from lgmd2jax._trials.reading import Draft, Reading, one_of
from lgmd2jax._trials.tables import drafts_of_trains

_UNIT_NAMES = ("unit_name", "name", "label")  # columns by which laboratories name units


class _Content(NamedTuple):
    """What is read of a file: seconds on the clock of its session."""

    animal: str | None
    units: Mapping[str, np.ndarray]
    trials: Mapping[str, Sequence[Any]]


def drafts_of_nwb(path: Path, reading: Reading) -> tuple[list[Draft], list[str]]:
    """The trials of the file. A column of their table is the time of the collision, by its name or as given.

    **Raises:** `ValueError` without pynwb, for a file without units or trials, where the unit must be chosen, and for a
    table of trials without the time of an event.
    """
    content = _content(path)
    units = list(content.units)
    spikes = np.sort(content.units[units[one_of("unit", units, reading.unit)]])
    columns = dict(content.trials)
    event = reading.event or next((name for name in columns if split(name)[0] in ROLES["event"]), None)
    if event is None:
        held = ", ".join(columns)
        raise ValueError(
            f"no column of the trials is named like a collision; name it by event (--event), one of {held}"
        )
    trains = [
        (1000 * spikes[(spikes >= start) & (spikes <= stop)]).tolist()
        for start, stop in zip(columns["start_time"], columns["stop_time"], strict=True)
    ]
    table = table_of(list(columns), list(zip(*columns.values(), strict=True)))
    # The format keeps all times in seconds, whatever is said.
    return drafts_of_trains(table, trains, dataclasses.replace(reading, time_unit="s"), content.animal or path.stem)


def _content(path: Path) -> _Content:
    need("pynwb", extra="nwb")
    import pynwb

    try:
        opened: Any = pynwb.NWBHDF5IO
        with opened(path, "r") as file:
            content = file.read()
            subject = content.subject.subject_id if content.subject is not None else None
            return _Content(subject, _units(content.units), _trials(content.trials))
    except (OSError, TypeError, KeyError) as error:
        raise ValueError(f"this is not an NWB file: {' '.join(str(error).split()):.100}") from error


def _units(table: Any) -> dict[str, np.ndarray]:
    """Spike times in seconds by the names of the units, or by their numbers where names are lacking or alike."""
    if table is None or "spike_times" not in table.colnames:
        return {}
    named = next((name for name in _UNIT_NAMES if name in table.colnames), None)
    names = table.id[:] if named is None or len(set(table[named][:])) < len(table) else table[named][:]
    return {str(name): np.asarray(table["spike_times"][row], dtype=float) for row, name in enumerate(names)}


def _trials(table: Any) -> dict[str, list[Any]]:
    """The columns that hold one value a trial; their numbers are those of the table where no column numbers them."""
    if table is None:
        raise ValueError("the file has no table of trials; add it, with the time of the collision as a column")
    columns = {name: list(table[name][:]) for name in table.colnames}
    columns = {name: values for name, values in columns.items() if all(np.ndim(value) == 0 for value in values)}
    if not any(split(name)[0] in ROLES["trial"] for name in columns):
        columns["trial"] = list(table.id[:])
    return columns
