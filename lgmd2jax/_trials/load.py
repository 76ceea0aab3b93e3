"""Trials from the files that laboratories have."""

import os
import re
from collections.abc import Sequence
from pathlib import Path

from lgmd2jax._targets.columns import Columns, read_columns
from lgmd2jax._trials.header import column_of
from lgmd2jax._trials.reading import Draft, Reading, trials_of
from lgmd2jax._trials.tables import drafts_of_table, drafts_of_two_tables
from lgmd2jax._trials.trials import Trials
from lgmd2jax._words import within

_TEXT = (".csv", ".tsv", ".txt")
_WITH_COMMA = re.compile(r"[-+]?\d+,\d+(e[-+]?\d+)?", re.IGNORECASE)
_WITH_POINT = re.compile(r"[-+]?\d*\.\d+(e[-+]?\d+)?", re.IGNORECASE)


def load_trials(
    *paths: str | os.PathLike,
    time_unit: str | None = None,
    animal: str | None = None,
    session: str | None = None,
    trial: str | None = None,
    time: str | None = None,
    l_over_v: str | float | int | None = None,
    event: str | float | int | None = None,
    conditions: Sequence[str] = (),
    window: tuple[float | int, float | int] | None = None,
    separator: str | None = None,
    decimal: str | None = None,
) -> Trials:
    """The trials in recordings.

    A text file with a header has a row a spike; or a column a trial; or a row a trial beside a second file with a row a
    spike, as `trials.csv` and `spikes.csv` of a folder. Columns are known by names such as `animal`, `trial`,
    `l_over_v_ms`, `spike_s`, `impact_s`. A row a spike whose time is empty is a trial without spikes.

    **Arguments:**

    - `paths`: files, or a folder of them.
    - `time_unit`: `"ms"`, `"s"` or `"us"`, of all times of which the file does not tell it; there is no default.
    - `animal`: the column of the animals, or else the name of the only one; by default that of the file.
    - `session`, `trial`, `time`: the columns of recordings, of trials and of spike times.
    - `l_over_v`: the column of l/|v|, or else its value in ms.
    - `event`: the column of the collision's time, or else this time; by default times are counted from it.
    - `conditions`: further columns by which stimuli are told apart.
    - `window`: what was recorded of each trial, in ms from the event; by default as far as the spikes of all.
    - `separator`, `decimal`: of a text file; by default they are found.

    **Raises:** `ValueError`, which names the file, for a missing unit, for times that cannot be those of a neuron, for
    two different trials of one name, and for cells that cannot be read; `OSError` where a file cannot be read.
    """
    reading = Reading(
        time_unit, animal, session, trial, time, l_over_v, event, tuple(conditions), window, separator, decimal
    )
    drafts: list[Draft] = []
    remarks: list[str] = []
    files = [file for path in paths for file in _files(Path(path))]
    if not files:
        raise ValueError("no file is named; give at least one")
    with within(", ".join(map(str, paths))):
        tables = []
        for file in files:
            with within(file.name):
                tables.append((file, _table(file, reading)))
        pair = _pair(tables, reading)
        if pair is not None:
            drafts, remarks = drafts_of_two_tables(*pair, reading, files[0].parent.name)
        else:
            for file, table in tables:
                with within(file.name):
                    own, more = drafts_of_table(table, reading, file.stem)
                drafts += own
                remarks += [f"{file.name}: {remark}" for remark in more]
        return trials_of(drafts, reading, remarks)


def _files(path: Path) -> list[Path]:
    """The file, or the readable ones of a folder."""
    if not path.exists():
        raise FileNotFoundError(f"there is no file {path}")
    if not path.is_dir():
        return [path]
    files = sorted(file for file in path.iterdir() if file.suffix.lower() in _TEXT and not file.name.startswith("."))
    if not files:
        raise ValueError(f"{path} holds no file ending in {', '.join(_TEXT)}")
    return files


def _table(path: Path, reading: Reading) -> Columns:
    """The cells of a text file, whose decimal sign is found where it is not given."""
    table = read_columns(path, reading.separator, reading.decimal or ".")
    if reading.decimal is not None:
        return table
    cells = [cell for row in table.rows for cell in row]
    if any(map(_WITH_COMMA.fullmatch, cells)) and not any(map(_WITH_POINT.fullmatch, cells)):
        return read_columns(path, reading.separator, ",")
    return table


def _pair(tables: Sequence[tuple[Path, Columns]], reading: Reading) -> tuple[Columns, Columns] | None:
    """Of two tables the one with a row a trial and the one with a row a spike, where they are such."""
    if len(tables) != 2:
        return None
    (_, one), (_, other) = tables
    for trials, spikes in ((one, other), (other, one)):
        if column_of("time", spikes, None) and not column_of("time", trials, None) and column_of("trial", trials, None):
            return trials, spikes
    return None
