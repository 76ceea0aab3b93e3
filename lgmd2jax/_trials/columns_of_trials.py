"""Trials from a table with a column a trial, whose spike times stand below its label."""

import itertools
from collections.abc import Sequence

from lgmd2jax._arguments.units import size_of
from lgmd2jax._targets.columns import Columns
from lgmd2jax._trials.header import CONDITIONS, UNIT_IN_BRACKETS, label_in, milliseconds, role_of, speeds_in_ms, split
from lgmd2jax._trials.reading import Draft, Reading

_PADDING = ("", "nan")  # of columns that are shorter than others
_CURE = (
    "name each A_lv20_trial3, say, or write rows animal, l_over_v_ms and trial above the times. Columns of firing "
    "rates are read by a protocol, not here"
)


def drafts_of_columns(table: Columns, reading: Reading, animal: str) -> list[Draft]:
    """The trials of a table with a column each.

    The label stands in the name of the column, as `A_lv20_trial3`, or in rows above the times, which begin with what
    they tell, as `animal`, `l_over_v_ms` and `trial`; the header is one of them.

    **Arguments:** `animal`: its name where the table tells none.

    **Raises:** `ValueError` for a label that tells no trial, for a missing unit, and for cells that are no numbers.
    """
    if len(table.header) == 1 and any(sign in table.header[0] for sign in ",;\t"):
        raise ValueError(
            f"there is one column, {table.header[0]!r}, separated by {table.separator!r}; give another separator"
        )
    for name in ("event", "l_over_v"):
        if isinstance(given := getattr(reading, name), str):
            raise ValueError(f"{name} is {given!r}, but each column is a trial; give its value")
    lines = [table.header, *table.rows]
    above = list(itertools.takewhile(lambda cells: role_of(cells[0]), lines))
    if above:
        names = [role_of(cells[0]) for cells in above]
        labels = [dict(zip(names, cells, strict=True)) for cells in zip(*(cells[1:] for cells in above), strict=True)]
        speed = next((cells[0] for cells in above if role_of(cells[0]) == "l_over_v"), "l_over_v")
        rows, first, unit = table.rows[len(above) - 1 :], 1, _unit_of_labels(lines[len(above) :])
    else:
        labels = [label_in(name) for name in table.header]
        speed, rows, first, unit = "l_over_v", table.rows, 0, _unit_of_names(table.header)
    drafts = []
    numbers = table.row_numbers[len(table.row_numbers) - len(rows) :]
    for place, label in enumerate(labels, start=first):
        name = table.header[place] if not above else f"column {place + 1}"
        times = _times(table, [cells[place] for cells in rows], numbers, name)
        size = milliseconds(f"spikes_{unit}" if unit else name, times, reading.time_unit)
        event = size * float(reading.event or 0)
        condition: dict[str, float | str] = {key: value for key, value in label.items() if key in CONDITIONS}
        if reading.l_over_v is not None:
            condition["l_over_v"] = float(reading.l_over_v)
        elif "l_over_v" in label:
            condition["l_over_v"] = speeds_in_ms(speed, [table.number(label["l_over_v"], name, 0)])[0]
        if "trial" not in label:
            raise ValueError(f"{name!r} names no trial; {_CURE}")
        who = reading.animal or label.get("animal") or animal
        spikes = [size * time - event for time in times]
        drafts.append(Draft(who, label.get("session", ""), label["trial"], condition, spikes))
    return drafts


def _unit_of_names(names: Sequence[str]) -> str | None:
    units = {match[1] for match in map(UNIT_IN_BRACKETS.search, names) if match is not None and size_of(match[1], "ms")}
    if len(units) > 1:
        raise ValueError(f"the columns have the units {' and '.join(sorted(units))}; give all of them the same one")
    return next(iter(units), None)


def _unit_of_labels(rows: Sequence[Sequence[str]]) -> str | None:
    """The unit in the first cell beside the times, as `spike_s`."""
    return next((split(cells[0])[1] for cells in rows if split(cells[0])[1]), None)


def _times(table: Columns, cells: Sequence[str], numbers: Sequence[int], name: str) -> list[float]:
    """The numbers of a column down to its last one."""
    end = max((place for place, cell in enumerate(cells, start=1) if cell.lower() not in _PADDING), default=0)
    return [table.number(cell, name, number) for number, cell in zip(numbers[:end], cells[:end], strict=True)]
