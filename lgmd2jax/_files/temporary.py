"""Names of what is being written: hidden, beside the place where it will appear, so that a kill leaves nothing else."""

import re
import secrets
from pathlib import Path

_TOKEN = r"\.[0-9a-f]{8}"
_LOCK = ".lock"


def temporary_beside(path: Path) -> Path:
    """A name in the same folder that nothing has yet, with the same suffix, since writers choose a format by it."""
    return path.with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix}")


def lock_beside(path: Path) -> Path:
    """The name of the lock of a folder."""
    return path.with_name(f".{path.name}{_LOCK}")


def is_temporary(path: Path) -> bool:
    """Whether this is such a name: what a killed process left."""
    name = path.name
    return name.startswith(".") and (name.endswith(_LOCK) or bool(re.fullmatch(rf".+{_TOKEN}(\.[^.]+)?", name)))


def temporaries_beside(path: Path) -> list[Path]:
    """What killed processes left that wrote to this path."""
    own = re.compile(re.escape(f".{path.stem}") + _TOKEN + re.escape(path.suffix))
    return [other for other in path.parent.iterdir() if own.fullmatch(other.name)]
