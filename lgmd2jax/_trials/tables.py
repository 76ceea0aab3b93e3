"""Trials from tables: a row a spike, a column a trial, or a row a trial beside a table with a row a spike."""

import dataclasses
from collections.abc import Sequence
from typing import Any

from lgmd2jax._targets.columns import Columns
from lgmd2jax._trials.columns_of_trials import drafts_of_columns
from lgmd2jax._trials.header import milliseconds
from lgmd2jax._trials.reading import Draft, Reading
from lgmd2jax._trials.roles import KEYS, Roles, roles_of


def drafts_of_table(table: Columns, reading: Reading, animal: str) -> tuple[list[Draft], list[str]]:
    """The trials of one table, and remarks on it.

    **Arguments:** `animal`: its name where the table tells none.

    **Raises:** `ValueError` for a table of none of the layouts, and for cells that cannot be read.
    """
    roles = roles_of(table, reading, animal)
    if "time" in roles.columns:
        return _rows_of_spikes(roles)
    if "trial" in roles.columns and len(table.header) < len(table.rows):
        held = ", ".join(map(repr, table.header))
        raise ValueError(f"no column is named like the time of a spike; name it by time (--time), one of {held}")
    return drafts_of_columns(table, reading, animal), []


def drafts_of_two_tables(
    trials: Columns, spikes: Columns, reading: Reading, animal: str
) -> tuple[list[Draft], list[str]]:
    """The trials of a table with a row a trial, whose spikes stand in another one.

    **Raises:** `ValueError` for tables that share no column of the trial, for two rows of one trial that are not alike,
    for spikes of no trial, and for cells that cannot be read.
    """
    roles = roles_of(trials, dataclasses.replace(reading, time=None), animal)
    spike_roles = roles_of(spikes, dataclasses.replace(reading, conditions=(), event=None, l_over_v=None), animal)
    if "time" not in spike_roles.columns:
        held = ", ".join(map(repr, spikes.header))
        raise ValueError(f"the spikes have no column named like a time; name it by time (--time), one of {held}")
    shared = [key for key in KEYS if key in roles.columns and key in spike_roles.columns]
    if "trial" not in shared:
        raise ValueError("the tables of trials and of spikes share no column of the trial; give both one of that name")
    found: dict[tuple[str, ...], tuple[Draft, float]] = {}
    repeated = 0
    rows = zip(roles.labels(shared), _rows_of_trials(roles), trials.row_numbers, strict=True)
    for key, (draft, event), number in rows:
        if key not in found:
            found[key] = draft, event
        elif found[key] == (draft, event):
            repeated += 1
        else:
            raise ValueError(f"row {number} is of {_told(shared, key)} again, and not alike; correct one of them")
    times = spike_roles.times("time") or []
    for key, time, number in zip(spike_roles.labels(shared), times, spikes.row_numbers, strict=True):
        if key not in found:
            raise ValueError(
                f"row {number} of the spikes is of {_told(shared, key)}, which has no row in the trials; add it"
            )
        draft, event = found[key]
        draft.spikes.append(time - event)
    remarks = [f"{repeated} rows of the trials appear twice, alike; each counts once"] if repeated else []
    return [draft for draft, _ in found.values()], [*remarks, *_unread(roles)]


def drafts_of_trains(
    trials: Columns, trains: Sequence[Sequence[float]], reading: Reading, animal: str
) -> tuple[list[Draft], list[str]]:
    """The trials of a table with a row a trial, and beside each row its spike times in ms, on the clock of the events.

    **Raises:** `ValueError` for cells that cannot be read, and for trials without names.
    """
    roles = roles_of(trials, reading, animal)
    drafts = []
    for (draft, event), train in zip(_rows_of_trials(roles), trains, strict=True):
        draft.spikes.extend(time - event for time in train)
        drafts.append(draft)
    return drafts, _unread(roles)


def _rows_of_trials(roles: Roles) -> list[tuple[Draft, float]]:
    """The trial of each row, without its spikes, and the time of its event in ms on the clock of the spikes."""
    labels, conditions, spans = roles.labels(), roles.condition_of_rows(), _spans(roles)
    drafts = [
        Draft(animal, session, trial, condition, span=span)
        for (animal, session, trial), condition, span in zip(labels, conditions, spans, strict=True)
    ]
    return list(zip(drafts, _events(roles), strict=True))


def _rows_of_spikes(roles: Roles) -> tuple[list[Draft], list[str]]:
    """A row a spike; a row without a time is a trial without spikes."""
    if "trial" not in roles.columns:
        raise ValueError(
            "no column is named like the number of a trial; name it by trial (--trial), one of "
            + ", ".join(map(repr, roles.table.header))
        )
    name = roles.columns["time"]
    cells = list(roles.table.numbered(name))
    values = [roles.table.number(cell, name, row) if cell else None for row, cell in cells]
    size = milliseconds(name, [value for value in values if value is not None], roles.time_unit)
    found: dict[Any, tuple[Draft, float]] = {}
    for (draft, event), value, number in zip(_rows_of_trials(roles), values, roles.table.row_numbers, strict=True):
        key = (draft.animal, draft.session, draft.name, tuple(draft.condition.items()))
        first, clock = found.setdefault(key, (draft, event))
        if (first.span, clock) != (draft.span, event):
            raise ValueError(f"row {number} has another event or span than rows of its trial before; correct one")
        if value is not None:
            first.spikes.append(size * value - event)
    return [draft for draft, _ in found.values()], _unread(roles)


def _events(roles: Roles) -> list[float]:
    """The time of the event in each row, in ms on the clock of the spikes."""
    events = roles.times("event")
    if events is not None:
        return events
    if not roles.event:
        return [0.0] * len(roles.table.rows)
    size = milliseconds(roles.columns.get("time", "event"), [roles.event], roles.time_unit)
    return [size * roles.event] * len(roles.table.rows)


def _spans(roles: Roles) -> list[tuple[float, float] | None]:
    """What was recorded in each row's trial, in ms from its event; None where the table does not tell."""
    starts, ends = roles.times("start"), roles.times("end")
    if starts is None or ends is None:
        return [None] * len(roles.table.rows)
    return [(start - event, end - event) for start, end, event in zip(starts, ends, _events(roles), strict=True)]


def _unread(roles: Roles) -> list[str]:
    """A remark on columns that might tell stimuli apart."""
    if not roles.others:
        return []
    names = ", ".join(map(repr, roles.others))
    return [f"columns not read: {names}; name by conditions (--conditions) those that tell stimuli apart"]


def _told(keys: Sequence[str], label: Sequence[str]) -> str:
    return ", ".join(f"{key} {value!r}" for key, value in zip(keys, label, strict=True))
