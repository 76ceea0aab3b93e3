"""Finished work on disk, a line each, so that a fit that was killed goes on from there."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lgmd2jax._files.atomic import replaced


class FileMemory(dict[str, Any]):
    """A dictionary that appends every entry that is set to a file at once. Without entries there is no file.

    **Arguments:** `digest`: of all that the work depends on. `resume`: whether to keep what the file holds.

    **Raises:** `ValueError` for a file with another digest, when it is to be resumed.
    """

    def __init__(self, path: Path, digest: str, resume: bool):
        super().__init__()
        self._path, self._digest, self._begun = path, digest, False
        if resume and path.is_file():
            first, *lines = path.read_text(encoding="utf-8", errors="replace").split("\n")
            if first != _line("digest", digest):
                raise ValueError(f"{path} keeps the work of another recipe, or of other data; run without --resume")
            self.update(_entries(lines))

    def __setitem__(self, key: str, value: Any) -> None:
        super().__setitem__(key, value)
        if self._begun:
            with open(self._path, "a", encoding="utf-8") as file:
                file.write(_line(key, value) + "\n")
        else:  # written anew: what a kill has torn at its end is gone
            lines = [_line("digest", self._digest), *(_line(*item) for item in self.items())]
            with replaced(self._path) as temporary:
                temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")
            self._begun = True

    def forget(self) -> None:
        """Remove the file: the results are written."""
        self._path.unlink(missing_ok=True)


def _line(key: str, value: Any) -> str:
    return json.dumps([key, value])


def _entries(lines: list[str]) -> Iterator[tuple[str, Any]]:
    for line in lines:
        try:
            entry = json.loads(line)
        except (ValueError, RecursionError):
            return
        if not (isinstance(entry, list) and len(entry) == 2 and isinstance(entry[0], str)):
            return
        yield entry[0], entry[1]
