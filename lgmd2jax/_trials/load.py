"""Trials from the files that laboratories have."""

import contextlib
import os
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from lgmd2jax._arguments.checked import checked
from lgmd2jax._targets.columns import Columns, read_columns
from lgmd2jax._trials.excel import sheets_of
from lgmd2jax._trials.header import column_of
from lgmd2jax._trials.matlab import drafts_of_matlab
from lgmd2jax._trials.neo_objects import drafts_of_neo, drafts_of_neo_file, is_neo
from lgmd2jax._trials.nwb import drafts_of_nwb
from lgmd2jax._trials.reading import Draft, Reading, trials_of
from lgmd2jax._trials.spike2 import drafts_of_spike2, is_spike2
from lgmd2jax._trials.tables import drafts_of_table, drafts_of_two_tables
from lgmd2jax._trials.trials import Trials
from lgmd2jax._words import within

_TEXT, _WORKBOOK = (".csv", ".tsv", ".txt", ".dat"), (".xlsx", ".xlsm")
_READERS: Mapping[str, Callable[[Path, Reading], tuple[list[Draft], list[str]]]] = {
    ".mat": drafts_of_matlab,
    ".nwb": drafts_of_nwb,
}
_TABLES = ("spikes", "trials")  # files of a folder that belong together, whatever else lies there
_WITH_COMMA = re.compile(r"[-+]?\d+,\d+(e[-+]?\d+)?", re.IGNORECASE)
_WITH_POINT = re.compile(r"[-+]?\d*\.\d+(e[-+]?\d+)?", re.IGNORECASE)


@checked
def load_trials(
    *sources: Any,
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
    unit: str | None = None,
) -> Trials:
    """The trials in recordings.

    A text file with a header, or a sheet of Excel, has a row a spike; or a column a trial; or a row a trial beside a
    second file or sheet with a row a spike, as `trials.csv` and `spikes.csv` of a folder. Columns are known by names
    such as `animal`, `trial`, `l_over_v_ms`, `spike_s`, `impact_s`. Where each row is a spike, one whose time is empty
    is a trial without spikes. A Matlab file holds a struct array with these names as fields, or vectors of them; an NWB
    file units and a table of trials; text exports of Spike2, Neo's objects and all files that Neo reads hold events.

    **Arguments:**

    - `sources`: files, folders of text files, blocks and segments of Neo.
    - `time_unit`: `"ms"`, `"s"` or `"us"`, of all times of which the file does not tell it; there is no default.
    - `animal`: the column of the animals, or else the name of the only one; by default that of the file.
    - `session`, `trial`, `time`: the columns of recordings, of trials and of spike times.
    - `l_over_v`: the column of l/|v|, or else its value in ms.
    - `event`: the column, channel or event of the collision, or else its time; by default times are counted from it.
    - `conditions`: further columns by which stimuli are told apart.
    - `window`: what was recorded of each trial, in ms from the event; by default as far as the spikes of all.
    - `separator`, `decimal`: of a text file; by default they are found.
    - `unit`: the neuron to read, of a file that holds several.

    **Raises:** `ValueError`, which names the file, for a missing unit, for times that cannot be those of a neuron, for
    two different trials of one name, for cells that cannot be read, and for an extra that is not installed; `OSError`
    where a file cannot be read.
    """
    reading = Reading(
        time_unit, animal, session, trial, time, l_over_v, event, tuple(conditions), window, separator, decimal, unit
    )
    if not sources:
        raise ValueError("no file is named; give at least one")
    files = [file for source in sources if not is_neo(source) for file in _files(source)]
    drafts: list[Draft] = []
    remarks: list[str] = []
    with within(", ".join("Neo" if is_neo(source) else str(source) for source in sources)):
        for objects in filter(is_neo, sources):
            drafts += drafts_of_neo(objects, reading, "animal")[0]
        tables: list[tuple[str, Columns]] = []
        for file in files:
            with _part(file.name, files):
                if (reader := _reader(file)) is None:
                    tables += _tables(file, reading)
                    continue
                own, more = reader(file, reading)
            drafts += own
            remarks += [f"{file.name}: {remark}" for remark in more]
        if (pair := _pair(tables)) is not None:
            name = files[0].parent.name if len(files) > 1 else files[0].stem
            tables, (own, more) = [], drafts_of_two_tables(*pair, reading, name)
            drafts += own
            remarks += more
        for name, table in tables:
            with _part(name, tables):
                own, more = drafts_of_table(table, reading, name)
            drafts += own
            remarks += [f"{name}: {remark}" for remark in more]
        return trials_of(drafts, reading, remarks)


def _part(name: str, parts: Sequence[Any]) -> AbstractContextManager[None]:
    """Name one of several parts of what is read in its errors."""
    return within(name) if len(parts) > 1 else contextlib.nullcontext()


def _files(source: str | os.PathLike) -> list[Path]:
    """The file, or the text files of a folder."""
    if not (isinstance(source, (str, os.PathLike)) and str(source)):
        raise ValueError(f"source is {source!r:.60}; give a path, or objects of Neo")
    path = Path(source)
    if not path.exists():
        raise FileNotFoundError(f"no such file: {path}")
    if not path.is_dir():
        return [path]
    files = sorted(file for file in path.iterdir() if file.suffix.lower() in _TEXT and not file.name.startswith("."))
    named = [file for file in files if file.stem.lower() in _TABLES]
    if len(named) == len(_TABLES):
        return named
    if not files:
        raise ValueError(f"{path} holds no file ending in {', '.join(_TEXT)}; name files")
    return files


def _reader(path: Path) -> Callable[[Path, Reading], tuple[list[Draft], list[str]]] | None:
    """What reads a file that is no table; None for one that is."""
    suffix = path.suffix.lower()
    if suffix in _TEXT:
        return drafts_of_spike2 if is_spike2(path) else None
    if suffix in _WORKBOOK:
        return None
    return _READERS.get(suffix, drafts_of_neo_file)


def _tables(path: Path, reading: Reading) -> list[tuple[str, Columns]]:
    """The tables of a file, each with the name that an animal has where the table tells none."""
    if path.suffix.lower() in _WORKBOOK:
        sheets = sheets_of(path, reading.decimal or ".")
        return [(path.stem, table) for _, table in sheets] if len(sheets) < 3 else sheets
    table = read_columns(path, reading.separator, reading.decimal or ".")
    cells = [cell for row in table.rows for cell in row]
    if (
        reading.decimal is None
        and any(map(_WITH_COMMA.fullmatch, cells))
        and not any(map(_WITH_POINT.fullmatch, cells))
    ):
        table = read_columns(path, reading.separator, ",")
    return [(path.stem, table)]


def _pair(tables: Sequence[tuple[str, Columns]]) -> tuple[Columns, Columns] | None:
    """Of two tables the one with a row a trial and the one with a row a spike, where they are such."""
    if len(tables) != 2:
        return None
    (_, one), (_, other) = tables
    for trials, spikes in ((one, other), (other, one)):
        if column_of("time", spikes) and not column_of("time", trials) and column_of("trial", trials):
            return trials, spikes
    return None
