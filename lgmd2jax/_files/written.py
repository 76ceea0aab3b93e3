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
    """Note a file or a folder that has appeared, other than in a folder that is noted or is still to appear."""
    places = path, *path.parents
    if not any(place in _noted or is_temporary(place) for place in places):
        _noted.append(path)
