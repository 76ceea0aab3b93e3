"""Trials from Matlab files, also those of version 7.3, which are HDF5 (the extra `matlab`)."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from lgmd2jax._compute.cluster import need
from lgmd2jax._targets.columns import Columns
from lgmd2jax._trials.cells import table_of
from lgmd2jax._trials.header import ROLES, milliseconds, split
from lgmd2jax._trials.reading import Draft, Reading
from lgmd2jax._trials.tables import drafts_of_table, drafts_of_trains

_HDF5 = b"MATLAB 7.3"


def drafts_of_matlab(path: Path, reading: Reading) -> tuple[list[Draft], list[str]]:
    """The trials of a struct array with a field of spike times, of a cell array of spike times beside vectors of equal
    length, of a matrix with a row a trial, which NaN fills up, or of vectors with a value a spike.

    **Raises:** `ValueError` for another content, for a missing unit, for rows of a matrix that do not rise, as of one
    with a column a trial, and for what is no Matlab file.
    """
    fields = _fields(_variables(path))
    name = reading.time or _name_of_trains(fields)
    if name not in fields:
        held = ", ".join(map(repr, fields))
        raise ValueError(f"no variable or field is named like spike times; name it by time (--time), one of {held}")
    if all(np.ndim(value) == 0 for value in fields[name]):
        return drafts_of_table(_table(fields), reading, path.stem)
    _check_rows(name, fields[name])
    trains = [_train(train, name, number) for number, train in enumerate(fields.pop(name), start=1)]
    size = milliseconds(name, [time for train in trains for time in train], reading.time_unit)
    trains = [[size * time for time in train] for train in trains]
    if not any(split(other)[0] in ROLES["trial"] for other in fields) and reading.trial is None:
        fields["trial"] = list(range(1, len(trains) + 1))
    return drafts_of_trains(_table(fields), trains, reading, path.stem)


def _train(values: Any, name: str, number: int) -> list[float]:
    """The spike times of a trial."""
    if np.iscomplexobj(values):
        raise ValueError(f"{name!r} of trial {number} is complex; give spike times")
    times = np.ravel(np.asarray(values, dtype=float))
    given = np.flatnonzero(~np.isnan(times))
    return times[: given[-1] + 1].tolist() if given.size else []


def _check_rows(name: str, rows: Sequence[Any]) -> None:
    """Refuse a matrix whose rows cannot be spike times: a column is a trial, or 0 fills it up, or it is a raster."""
    if len({np.shape(row) for row in rows}) > 1 or np.asarray(rows).dtype.kind not in "biuf":
        return
    steps = np.diff(np.asarray(rows, dtype=float).reshape(len(rows), -1))
    if not np.all((steps > 0) | np.isnan(steps)):
        raise ValueError(
            f"times in the rows of the matrix {name!r} do not rise; give a row for each trial (transpose it), filled "
            "up with NaN"
        )


def _table(fields: Mapping[str, Sequence[Any]]) -> Columns:
    return table_of(list(fields), list(zip(*fields.values(), strict=True)))


def _name_of_trains(fields: Mapping[str, Sequence[Any]]) -> str:
    return next((name for name in fields if split(name)[0] in ROLES["time"]), "")


def _fields(variables: Mapping[str, Any]) -> dict[str, list[Any]]:
    """The values of each name, one for each trial or spike.

    **Raises:** `ValueError` for variables of different lengths.
    """
    if len(variables) == 1:
        (value,) = variables.values()
        if isinstance(value, Mapping):
            return _fields(value)
        if isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            return {name: [item.get(name) for item in value] for name in value[0]}
    lists = {
        name: list(value)
        for name, value in variables.items()
        if isinstance(value, list) or (isinstance(value, np.ndarray) and value.ndim)
    }
    lengths = {len(values) for values in lists.values()}
    if len(lengths) != 1:
        told = ", ".join(f"{name} ({len(values)})" for name, values in lists.items()) or ", ".join(variables)
        raise ValueError(
            f"its variables are not trials: {told}; save one struct array with a field of spike times, or a cell array "
            "of them beside vectors as long"
        )
    return lists


def _variables(path: Path) -> dict[str, Any]:
    """The variables of the file; structs are mappings, arrays of structs and cells are lists."""
    with open(path, "rb") as file:
        is_hdf5 = file.read(len(_HDF5)) == _HDF5
    if is_hdf5:
        return _hdf5(path)
    try:
        content = scipy.io.loadmat(path, simplify_cells=True)
    except (ValueError, TypeError, NotImplementedError, OSError, IndexError) as error:
        raise ValueError(f"this is not a Matlab file: {error}") from error
    return {name: _plain(value) for name, value in content.items() if not name.startswith("__")}


def _plain(value: Any) -> Any:
    """Arrays of objects as lists."""
    if isinstance(value, np.ndarray) and value.dtype == object:
        return [_plain(item) for item in value.ravel()]
    return value


def _hdf5(path: Path) -> dict[str, Any]:
    need("h5py", extra="matlab")
    import h5py

    try:
        with h5py.File(path) as file:
            return {name: _of_hdf5(file, value) for name, value in file.items() if not name.startswith("#")}
    except (ValueError, KeyError, RuntimeError, OSError) as error:
        raise ValueError(f"this is not a Matlab file: {' '.join(str(error).split()):.100}") from error


def _of_hdf5(file: Any, value: Any) -> Any:
    """A dataset or group as `scipy.io.loadmat` would give it."""
    if hasattr(value, "keys"):  # a struct, or an array of them: each field then holds references
        fields = {name: _of_hdf5(file, field) for name, field in value.items()}
        is_array = all(field.dtype == "object" and "MATLAB_class" not in field.attrs for field in value.values())
        if not is_array:
            return fields
        return [dict(zip(fields, row, strict=True)) for row in zip(*fields.values(), strict=True)]
    if value.attrs.get("MATLAB_empty", 0):
        return np.zeros(0)
    kind = value.attrs.get("MATLAB_class", b"")
    array = value[()]
    if array.dtype == object:
        return [_of_hdf5(file, file[reference]) for reference in np.ravel(array, order="F")]
    if kind == b"char":
        return "".join(map(chr, np.ravel(array)))
    array = np.squeeze(array.T)
    return array.item() if array.ndim == 0 else array
