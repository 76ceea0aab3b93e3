"""Which files a command has written, for what it says where it is stopped."""

from pathlib import Path

from lgmd2jax._files.temporary import is_temporary

_noted: list[Path] = []


def noted() -> list[Path]:
    """A list of the files and folders that are written from now on; it grows as they appear."""
    global _noted
    _noted = []
    return _noted


def note(path: Path) -> None:
    """Note a file or a folder that has appeared under its own name, and not as a part of what is still to appear."""
    if path not in _noted and not any(map(is_temporary, (path, *path.parents))):
        _noted.append(path)
