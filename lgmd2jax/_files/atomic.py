"""Files appear whole or not at all; a TOML or JSON file that is none is refused."""

import contextlib
import json
import os
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from lgmd2jax._files.temporary import temporary_beside
from lgmd2jax._files.written import note


@contextlib.contextmanager
def replaced(path: str | os.PathLike, *, is_result: bool = True) -> Iterator[Path]:
    """Write to the yielded temporary path; it becomes `path` when the block ends well and is removed when it does not.

    The temporary file stands in the same folder, with the same suffix (writers choose a format by it), and is made at
    once, so that a folder that cannot be written to is known before the work starts.

    **Arguments:** `is_result`: whether a user is told of it, other than of a cache.

    **Raises:** `ValueError` when `path` cannot become a file: its folder does not exist or refuses, or it is no file;
    `OSError`, which names the folder, for a disk that is full.
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise ValueError(f"the folder {path.parent} does not exist; make it first, or write {path.name} elsewhere")
    if path.exists() and not path.is_file():
        raise ValueError(f"{path} exists and is not a file; give another name")
    temporary = temporary_beside(path)
    try:
        temporary.touch(exist_ok=False)
    except OSError as error:
        raise ValueError(f"cannot write {path}: {error.strerror}") from error
    try:
        with naming(path.absolute().parent):
            yield temporary
        os.replace(temporary, path)
        if is_result:
            note(path)
    finally:
        temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def naming(folder: Path) -> Iterator[None]:
    """Name the folder in an error of the system about what is written there, which knows no name."""
    try:
        yield
    except OSError as error:
        if error.errno is None or error.filename is not None:
            raise
        raise type(error)(error.errno, error.strerror, str(folder)) from error


@contextlib.contextmanager
def all_replaced(
    paths: Iterable[Path | None], kept: Iterable[str | os.PathLike | None] = ()
) -> Iterator[dict[Path, Path]]:
    """The temporary path of each of several files, as of `replaced`; None is a file that nobody wants.

    **Arguments:** `kept`: what is read, and so must not be written over.

    **Raises:** `ValueError` as `replaced`, and for a file that is named twice, or is one of those that are kept.
    """
    wanted = [path for path in paths if path is not None]
    taken = {Path(path).resolve() for path in kept if path is not None}
    for path in wanted:
        if (place := path.resolve()) in taken:
            raise ValueError(f"{path.name} is named twice; what is read and what is written need names of their own")
        taken.add(place)
    with contextlib.ExitStack() as stack:
        yield {path: stack.enter_context(replaced(path)) for path in wanted}


def check_file(path: Path) -> None:
    """Raise `IsADirectoryError` for a folder, and `ValueError` for a named pipe, whose reader may wait for ever.

    What a shell makes of `<(...)` is none with a name of its own.
    """
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder; give a file")
    if path.is_fifo() and path.parent != Path("/dev/fd"):
        raise ValueError(f"{path} is a pipe; write what comes from it into a file, and give that")


def write_json(path: Path, content: Any) -> None:
    """Write plain data as JSON, which knows no NaN."""
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def read_toml(path: Path) -> dict[str, Any]:
    """The tables of a TOML file.

    **Raises:** `ValueError` that names the file, for what is not TOML; `OSError` where it cannot be read.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:  # also a number of 5,000 digits, and 1,000 lists in each other
        raise ValueError(f"{path} is not a TOML file: {_reason(error)}") from error


def read_json(path: Path) -> Any:
    """The content of a JSON file.

    **Raises:** `ValueError` that names the file, for what is not JSON; `OSError` where it cannot be read.
    """
    check_file(path)
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not a JSON file: {_reason(error)}") from error


def _reason(error: Exception) -> str:
    return "it holds no text in UTF-8" if isinstance(error, UnicodeDecodeError) else str(error)
