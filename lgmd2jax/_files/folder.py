"""A folder of results appears whole or stays as it was."""

import contextlib
import ctypes
import os
import shutil
import sys
from collections.abc import Collection, Iterator
from pathlib import Path

from lgmd2jax._files.atomic import naming
from lgmd2jax._files.temporary import is_temporary, temporary_beside
from lgmd2jax._files.written import note


@contextlib.contextmanager
def replaced_folder(folder: Path, marker: str, own: Collection[str]) -> Iterator[Path]:
    """Write into the yielded temporary folder; it becomes `folder` in one step when the block ends well.

    What else stands in the old folder, notes for example, is carried over; files named in `own` are not.

    **Arguments:** `marker`: the file by which a folder of results is known. `own`: the files that results consist of.

    **Raises:** `ValueError` as `check_folder`; `OSError`, which names the folder, for a disk that is full.
    """
    check_folder(folder, marker)
    temporary = temporary_beside(folder.absolute())
    try:
        temporary.mkdir()
    except OSError as error:
        raise ValueError(f"cannot write {folder}: {error.strerror}") from error
    try:
        with naming(folder):
            yield temporary
        if folder.exists():
            for other in folder.iterdir():
                if other.name not in own and not is_temporary(other):
                    (shutil.copytree if other.is_dir() else shutil.copy2)(other, temporary / other.name)
            _exchange(temporary, folder)
        else:
            temporary.rename(folder)
        note(folder)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def check_folder(folder: Path, marker: str) -> None:
    """Raise `ValueError` for a path at which results cannot be written: no folder, one of something else, no parent."""
    if folder.is_dir():
        # What a killed process left there is nothing of anybody's.
        if not all(map(is_temporary, folder.iterdir())) and not (folder / marker).is_file():
            raise ValueError(f"{folder} holds something else than results (there is no {marker}); name another folder")
    elif folder.exists():
        raise ValueError(f"{folder} exists and is not a folder; name another one")
    elif not folder.absolute().parent.is_dir():
        raise ValueError(f"the folder {folder.absolute().parent} does not exist; make it first, or write elsewhere")


def _exchange(new: Path, old: Path) -> None:
    """Swap two folders, in one step where the system can: there is no moment without results."""
    library = ctypes.CDLL(None, use_errno=True) if sys.platform in ("linux", "darwin") else None
    here, swap = -100 if sys.platform == "linux" else -2, 2
    for name in ("renameat2", "renameatx_np"):
        rename = getattr(library, name, None)
        if rename is not None and rename(here, os.fsencode(new), here, os.fsencode(old), swap) == 0:
            return
    aside = old.with_name(f"{new.name}.old")
    old.rename(aside)
    new.rename(old)
    aside.rename(new)
