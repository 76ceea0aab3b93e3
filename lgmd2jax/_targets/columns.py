"""The columns of a CSV file by name: its separator, its decimal sign, which column is the time, and in which unit."""

import codecs
import contextlib
import csv
import dataclasses
import io
import math
import os
import re
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

import numpy as np

from lgmd2jax._arguments.units import size_of
from lgmd2jax._files.atomic import check_file
from lgmd2jax._words import nearest

Where = Mapping[str, str | float | int]

_SEPARATORS = (",", ";", "\t", "|")
_LONGEST = 40  # characters of a cell in a message
_LOOKED_AT = 200  # rows by which the separator is found
_TIMES = {"t", "time", "times", "timestamp", "timestamps"}
_OTHER_CLOCKS = {"h", "hr", "hrs", "hours", "days", "frame", "frames", "sample", "samples", "bin", "bins", "ticks"}
_TIMES_ALONE = {"ms", "msec", "milliseconds", "s", "sec", "seconds"}  # a column "min" may hold a minimum


@dataclasses.dataclass(frozen=True)
class Columns:
    """The cells of a file as text.

    - `header`: the names, each as often as it stands there.
    - `rows`: as long as the header. `row_numbers`: those of the file, from 1.
    - `separator`: that of the cells, "" of what is no text file. `decimal`: the sign in numbers, "." or ",".
    """

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    row_numbers: tuple[int, ...]
    separator: str
    decimal: str

    def text(self, name: str) -> tuple[str, ...]:
        """The cells of a column.

        **Raises:** `ValueError` for a column that is not there, and for one of which there are two.
        """
        count = self.header.count(name)
        if count > 1:
            raise ValueError(f"{count} columns are named {name!r}; give each a name of its own")
        if not count:
            known = nearest(name, self.header)
            cells = f" (cells are separated by {self.separator!r})" if self.separator else ""
            raise ValueError(f"no column {name!r}; choose {known}{cells}")
        place = self.header.index(name)
        return tuple(row[place] for row in self.rows)

    def numbered(self, name: str) -> Iterator[tuple[int, str]]:
        """The cells of a column with the numbers of their rows."""
        return zip(self.row_numbers, self.text(name), strict=True)

    def numbers(self, name: str) -> np.ndarray:
        """A column as numbers.

        **Raises:** as `text`, and `ValueError` for a cell that is no finite number.
        """
        cells = self.text(name)
        if self.decimal == ".":
            with contextlib.suppress(ValueError):
                values = np.array(cells, dtype=float)
                if np.all(np.isfinite(values)) and not any("_" in cell for cell in cells):
                    return values
        return np.array([self.number(cell, name, row) for row, cell in self.numbered(name)])

    def number(self, text: str, name: str, row: int) -> float:
        """A cell of a column as a number.

        **Raises:** `ValueError`, which names column and row, for what is no finite number.
        """
        plain = text
        if self.decimal == ",":
            plain = "" if "." in text else text.replace(",", ".")
        try:
            value = math.nan if "_" in plain else float(plain)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            cure = "leave such rows out"
            if self.decimal == "." and re.fullmatch(r"[-+]?\d*,\d+(e[-+]?\d+)?", text, re.IGNORECASE):
                cure = "give decimal = ',' if that is its decimal sign"
            raise ValueError(
                f"column {name!r} holds {text[:_LONGEST]!r} in row {row}, which is no finite number; {cure}"
            )
        return value

    def time(self, name: str | None, unit: str | None, others: Collection[str]) -> tuple[str, float]:
        """Which column is the time, and how many ms one of its unit is.

        **Arguments:** `name`: of the column, by default the only one with the name of a time, such as `time_ms`,
        `t` or `Time (s)`. `unit`: by default that in its name, else ms. `others`: columns that are something else.

        **Raises:** `ValueError` for no such column, for several, and for a unit that is none of time.
        """
        if len(self.header) == 1:
            raise ValueError(
                f"there is one column, {self.header[0]!r}, separated by {self.separator!r}; give another one"
            )
        if name is None:
            names = [column for column in dict.fromkeys(self.header) if column not in others and _unit_of(column)]
            if len(names) != 1:
                what = f"columns {' and '.join(map(repr, names))} are" if names else "no column is"
                held = ", ".join(map(repr, self.header))
                raise ValueError(f"{what} named like a time; name it by time = '...', one of {held}")
            name = names[0]
        own = _unit_of(name)
        if unit is None and own in (None, "time") and (other := _no_unit_of_time(name)):
            raise ValueError(
                f"column {name!r} counts in {other!r}, which is not a unit of time here; convert it, or give time_unit"
            )
        if unit is None:
            return name, size_of(own or "ms", "ms") or 1.0
        size = size_of(unit, "ms")
        if size is None:
            raise ValueError(f"time_unit is {unit!r}; give 'ms', 's', 'us' or 'min'")
        if own not in (None, "time") and size_of(own, "ms") != size:
            raise ValueError(f"time_unit is {unit!r}, but the column is named {name!r}; correct one of them")
        return name, size

    def where(self, wanted: Where | None) -> "Columns":
        """The rows in which columns hold these values, numbers by their value and text to the letter.

        **Raises:** `ValueError` for a column that is not there, and where no row is left.
        """
        table = self
        for name, value in (wanted or {}).items():
            chosen = [i for i, cell in enumerate(table.text(name)) if self._equal(cell, value)]
            if not chosen:
                held = ", ".join(map(repr, list(dict.fromkeys(table.text(name)))[:10]))
                raise ValueError(f"where: no row has {name} = {value!r}; those that are left have {held}")
            rows, numbers = (tuple(column[i] for i in chosen) for column in (table.rows, table.row_numbers))
            table = dataclasses.replace(table, rows=rows, row_numbers=numbers)
        return table

    def _equal(self, cell: str, value: str | float | int) -> bool:
        if cell == str(value):
            return True
        try:
            return math.isclose(self.number(cell, "", 0), float(value), rel_tol=1e-9)
        except ValueError:
            return False


def read_columns(path: str | os.PathLike, separator: str | None = None, decimal: str = ".") -> Columns:
    """Read a CSV file with a header. Where no separator is given, the one that divides all rows alike is taken.

    **Raises:** `ValueError` for what is no such file, for rows of another length than the header, and where several
    separators could be meant; `OSError` where it cannot be read.
    """
    if decimal not in (".", ","):
        raise ValueError(f"decimal is {decimal!r}; give '.' or ','")
    if separator is not None and (len(separator) != 1 or separator == decimal):
        raise ValueError(f"separator is {separator!r} and decimal {decimal!r}; give one character each, not the same")
    check_file(Path(path))
    try:
        text = _decoded(Path(path).read_bytes())
        separator = separator or _separator(text, decimal)
        header, *rows = list(_cells(text, separator)) or [[]]
    except csv.Error as error:
        raise ValueError(f"not a CSV file: {error}") from error
    if not rows:
        raise ValueError("no rows; give a header and a row for each time")
    for number, row in enumerate(rows, start=1):
        if len(row) != len(header):
            raise ValueError(
                f"row {number} has {len(row)} cells and the header {len(header)}, separated by {separator!r}; "
                "make them equal, or give another separator"
            )
    numbers = tuple(range(1, len(rows) + 1))
    return Columns(tuple(header), tuple(map(tuple, rows)), numbers, separator, decimal)


def _decoded(content: bytes) -> str:
    """The text: UTF-8, or UTF-16 where it begins as such, as Excel's "Unicode text" does.

    **Raises:** `ValueError` for another encoding.
    """
    encoding = "utf-16" if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) else "utf-8-sig"
    try:
        return content.decode(encoding)
    except UnicodeDecodeError as error:
        raise ValueError(
            f"not a CSV file in UTF-8: byte {error.start} is {content[error.start]:#x}; save it as UTF-8"
        ) from error


def _cells(text: str, separator: str) -> Iterator[list[str]]:
    """The lines that are not empty, cut into cells; by blanks where the separator is one."""
    if separator == " ":
        yield from (line.split() for line in text.splitlines() if line.strip())
        return
    for line in csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True):
        if line:
            yield [cell.strip() for cell in line]


def _separator(text: str, decimal: str) -> str:
    """The one that divides header and rows into the same number of cells, more than one; else the likeliest."""
    counts: dict[str, Counter[int]] = {}
    for separator in (*_SEPARATORS, " "):
        if separator == decimal:
            continue
        try:
            lines = [row for row, _ in zip(_cells(text, separator), range(_LOOKED_AT), strict=False)]
        except csv.Error:
            continue
        counts[separator] = Counter(map(len, lines))
    even = [separator for separator, lengths in counts.items() if len(lengths) == 1 and min(lengths) > 1]
    even = [separator for separator in even if separator != " "] or even
    if len(even) > 1:
        raise ValueError(f"cells could be separated by {' or '.join(map(repr, even))}; give the separator")
    uneven = [separator for separator in counts if separator != " " and max(counts[separator], default=0) > 1]
    return (even or uneven or [","])[0]


def _no_unit_of_time(name: str) -> str | None:
    """What the name of a column without a unit of time counts in instead, as far as it tells."""
    inside = re.search(r"[(\[]\s*([^)\]]*?)\s*[)\]]\s*$", name)
    last = re.split(r"[\W_]+", name.rstrip(")] "))[-1].lower()
    return inside[1] if inside else last if last in _OTHER_CLOCKS else None


def _unit_of(name: str) -> str | None:
    """The unit in the name of a column of times, `"time"` for one without a unit; None for another column."""
    words = [word for word in re.split(r"[^\w/]+|_", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name)) if word]
    unit = next((word for word in reversed(words) if size_of(word, "ms")), None)
    is_time = _TIMES & {word.lower() for word in words} or (len(words) == 1 and words[0].lower() in _TIMES_ALONE)
    return (unit or "time") if is_time else None
