"""The sheets of an Excel workbook (the extra `excel`)."""

import zipfile
from pathlib import Path

from lgmd2jax._compute.cluster import need
from lgmd2jax._targets.columns import Columns
from lgmd2jax._trials.cells import cell_of, table_of


def sheets_of(path: Path) -> list[tuple[str, Columns]]:
    """The names of the sheets that hold something, and their cells.

    **Raises:** `ValueError` without openpyxl, for what is no workbook, and for one that holds nothing.
    """
    need("openpyxl", extra="excel")
    import openpyxl
    from openpyxl.utils.exceptions import InvalidFileException

    try:
        workbook = openpyxl.load_workbook(path, read_only=True, data_only=True)
    except (InvalidFileException, zipfile.BadZipFile, KeyError) as error:
        raise ValueError("this is no Excel workbook; save it as .xlsx, or as CSV") from error
    sheets = []
    try:
        for sheet in workbook.worksheets:
            rows = [row for row in sheet.iter_rows(values_only=True) if any(cell is not None for cell in row)]
            if len(rows) > 1:
                width = max(place for row in rows for place, cell in enumerate(row, start=1) if cell_of(cell))
                header, *body = [(*row, *[None] * width)[:width] for row in rows]
                sheets.append((sheet.title, table_of(header, body)))
    finally:
        workbook.close()
    if not sheets:
        raise ValueError("no sheet holds a header and a row")
    return sheets
