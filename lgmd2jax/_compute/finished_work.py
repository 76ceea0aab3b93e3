"""Finished work, kept as plain data, so that what was stopped or killed goes on from there."""

import json
from collections.abc import Iterator, MutableMapping
from pathlib import Path
from typing import Any

from lgmd2jax._files.atomic import replaced

Memory = MutableMapping[str, Any]  # of finished work, by what was done


class MemoryPart(Memory):
    """The entries of a memory whose keys begin with a name, so that several fits can share the memory."""

    def __init__(self, memory: Memory, name: str):
        self._memory, self._name = memory, f"{name}: "

    def __getitem__(self, key: str) -> Any:
        return self._memory[self._name + key]

    def __setitem__(self, key: str, value: Any) -> None:
        self._memory[self._name + key] = value

    def __delitem__(self, key: str) -> None:
        del self._memory[self._name + key]

    def __iter__(self) -> Iterator[str]:
        return (key.removeprefix(self._name) for key in self._memory if key.startswith(self._name))

    def __len__(self):
        return sum(1 for _ in self)


class FileMemory(dict[str, Any]):
    """A dictionary that appends every entry that is set to a file at once. Without entries there is no file.

    **Arguments:** `digest`: of all that the work depends on. `resume`: whether to keep what the file holds.

    **Raises:** `ValueError` for a file with another digest, when it is to be resumed, and where the disk refuses.
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
        try:
            self._write(key, value)
        except OSError as error:
            reason = error.strerror or str(error)
            raise ValueError(f"cannot write {self._path}: {reason}; make room, and continue with --resume") from error

    def _write(self, key: str, value: Any) -> None:
        if self._begun:
            with open(self._path, "a", encoding="utf-8") as file:
                file.write(_line(key, value) + "\n")
        else:  # written anew: what a kill has torn at its end is gone
            lines = [_line("digest", self._digest), *(_line(*item) for item in self.items())]
            with replaced(self._path, is_result=False) as temporary:
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
