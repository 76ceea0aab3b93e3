"""Finished work on disk, a line each, so that a fit that was killed goes on from there."""

import json
from collections.abc import Iterator, MutableMapping
from pathlib import Path
from typing import Any

from lgmd2jax._files import replaced


class FileMemory(MutableMapping[str, Any]):
    """A mapping whose every entry is appended to a file at once. Without entries there is no file.

    **Arguments:** `digest`: of all that the work depends on. `resume`: whether to keep what the file holds.

    **Raises:** `ValueError` for a file with another digest, when it is to be resumed.
    """

    def __init__(self, path: Path, digest: str, resume: bool):
        self._path, self._digest, self._entries, self._begun = path, digest, {}, False
        if resume and path.is_file():
            first, *lines = path.read_text(encoding="utf-8").split("\n")
            if first != _line("digest", digest):
                raise ValueError(f"{path} keeps the work of another recipe, or of other data; run without --resume")
            self._entries = dict(_entries(lines))

    def __getitem__(self, key: str) -> Any:
        return self._entries[key]

    def __setitem__(self, key: str, value: Any) -> None:
        self._entries[key] = value
        if self._begun:
            with open(self._path, "a", encoding="utf-8") as file:
                file.write(_line(key, value) + "\n")
        else:  # written anew: what a kill has torn at its end is gone
            lines = [_line("digest", self._digest), *(_line(*item) for item in self._entries.items())]
            with replaced(self._path) as temporary:
                temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")
            self._begun = True

    def __delitem__(self, key: str) -> None:
        raise NotImplementedError("finished work is not forgotten; see forget()")

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def forget(self) -> None:
        """Remove the file: the results are written."""
        self._path.unlink(missing_ok=True)


def _line(key: str, value: Any) -> str:
    return json.dumps([key, value])


def _entries(lines: list[str]) -> Iterator[tuple[str, Any]]:
    for line in lines:
        try:
            key, value = json.loads(line)
        except ValueError:
            return
        yield key, value
