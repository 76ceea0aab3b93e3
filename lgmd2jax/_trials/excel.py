"""The sheets of an Excel workbook (the extra `excel`)."""

import re
import zipfile
from contextlib import closing
from pathlib import Path
from typing import Any

from lgmd2jax._compute.cluster import need
from lgmd2jax._targets.columns import Columns
from lgmd2jax._trials.cells import cell_of, table_of

_WITH_COMMA = re.compile(r"[-+]?\d+,\d+")


def sheets_of(path: Path, decimal: str = ".") -> list[tuple[str, Columns]]:
    """The names of the sheets that hold something, and their cells.

    **Arguments:** `decimal`: the sign in numbers that are kept as text.

    **Raises:** `ValueError` without openpyxl, for what is no workbook, and for one that holds nothing, or a formula
    without its value.
    """
    need("openpyxl", extra="excel")
    import openpyxl
    from openpyxl.utils.exceptions import InvalidFileException

    try:
        workbook = openpyxl.load_workbook(path, read_only=True, data_only=True)
        formulas = openpyxl.load_workbook(path, read_only=True)
    except (InvalidFileException, zipfile.BadZipFile, KeyError) as error:
        raise ValueError("this is not an Excel workbook; save it as .xlsx, or as CSV") from error
    except AttributeError as error:  # of openpyxl, on a sheet that is a chart
        raise ValueError("this workbook holds an empty chart; remove it, or save the sheet as CSV") from error
    sheets = []
    try:
        for sheet in workbook.worksheets:
            _check_formulas(sheet, formulas[sheet.title])
            rows = [row for row in sheet.iter_rows(values_only=True) if any(cell is not None for cell in row)]
            if decimal == ",":
                rows = [tuple(map(_with_point, row)) for row in rows]
            if len(rows) > 1:
                width = max(place for row in rows for place, cell in enumerate(row, start=1) if cell_of(cell))
                header, *body = [(*row, *[None] * width)[:width] for row in rows]
                sheets.append((sheet.title, table_of(header, body)))
    finally:
        workbook.close()
        formulas.close()
    if not sheets:
        raise ValueError("no sheet holds a header and a row")
    return sheets


def _check_formulas(values: Any, formulas: Any) -> None:
    """Refuse formulas whose values the file does not hold, as of a program that computes none: they look like empty."""
    # Rows that nobody reads to the end keep the file open until they are closed.
    with closing(values.iter_rows(values_only=True)) as shown, closing(formulas.iter_rows(values_only=True)) as written:
        for number, cells in enumerate(zip(shown, written, strict=False), start=1):
            for value, text in zip(*cells, strict=False):
                if value is None and isinstance(text, str) and text.startswith("="):
                    raise ValueError(
                        f"row {number} of the sheet {values.title!r} holds the formula {text!r:.40} without its value; "
                        "open the file in Excel and save it"
                    )


def _with_point(cell: Any) -> Any:
    """A number with a decimal comma that is kept as text, with a point; all else as it is."""
    return cell.replace(",", ".") if isinstance(cell, str) and _WITH_COMMA.fullmatch(cell.strip()) else cell
