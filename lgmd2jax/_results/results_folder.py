"""A folder of results that appears as soon as there is a model, and to which figures and later parts are added."""

import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from lgmd2jax._files.atomic import read_json, write_json
from lgmd2jax._files.folder import replaced_folder
from lgmd2jax._reports.page import report_page
from lgmd2jax._reports.section import Section, as_html, as_text
from lgmd2jax._words import warn_unfinished
from lgmd2jax.fitting._search.descent import STOPPED

MARKER = "fit.json"
ALARM_FIT = "lgmd2jax-alarm-fit"  # the format of that file, of a fit to labelled clips
_DOCUMENTS = (MARKER, "report.txt", "report.html")
SEARCH, FIGURES = "the search", "the figures"  # as parts that are still to come
Write = Callable[[Path], None]  # files into a folder


@dataclasses.dataclass(frozen=True)
class Documents:
    """What is written anew with each part: the content of fit.json, and the sections of the report."""

    content: dict[str, Any]
    sections: Sequence[Section]


@dataclasses.dataclass(frozen=True)
class ResultsFolder:
    """A folder that is always whole: each step replaces the files that change, all at once.

    - `title`: of the report. `figures`: PNG files that it shows. `files`: all others that results may consist of.
    """

    path: Path
    title: str
    figures: tuple[str, ...]
    files: tuple[str, ...]

    def begin(self, documents: Documents, write: Write) -> None:
        """Put the results in the place of what is there. `write`: all but figures and documents.

        **Raises:** `ValueError` for a folder that holds something else, or that cannot be written.
        """
        with replaced_folder(self.path, MARKER, (*_DOCUMENTS, *self.figures, *self.files)) as new:
            write(new)
            self._write(documents, new, ())

    def draw(self, documents: Documents, draw: Write) -> None:
        """Add the figures."""
        with replaced_folder(self.path, MARKER, (*_DOCUMENTS, *self.figures)) as new:
            draw(new)
            self._write(documents, new, [new / name for name in self.figures])

    def add(self, documents: Documents, write: Write | None = None, names: Sequence[str] = ()) -> None:
        """Add a part. `write`: the files of these names, where the part has any of its own."""
        with replaced_folder(self.path, MARKER, (*_DOCUMENTS, *names)) as new:
            if write is not None:
                write(new)
            self._write(documents, new, [self.path / name for name in self.figures])

    def _write(self, documents: Documents, folder: Path, figures: Sequence[Path]) -> None:
        write_json(folder / MARKER, documents.content)
        (folder / "report.txt").write_text(as_text(documents.sections) + "\n", encoding="utf-8")
        page = report_page(self.title, figures, as_html(documents.sections))
        (folder / "report.html").write_text(page, encoding="utf-8")


def is_finished(folder: Path) -> bool:
    """Whether a folder holds results of which nothing is still to come."""
    try:
        content = read_json(folder / MARKER)
        return not content.get("unfinished") and content.get("result") != STOPPED
    except (OSError, ValueError, AttributeError):
        return False


def warn_if_unfinished(folder: Path, parts: Sequence[str]) -> None:
    """Say that results are not whole yet. `parts`: what is still to come."""
    if parts:
        warn_unfinished(f"{folder} is unfinished: {', '.join(parts)}")
