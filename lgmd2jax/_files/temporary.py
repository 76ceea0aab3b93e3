"""Names of what is being written: hidden, beside the place where it will appear, so that a kill leaves nothing else."""

import re
import secrets
from pathlib import Path

_TOKEN = re.compile(r"\..+\.[0-9a-f]{8}(\.[^.]+)?")


def temporary_beside(path: Path) -> Path:
    """A name in the same folder that nothing has yet, with the same suffix, since writers choose a format by it."""
    return path.with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix}")


def is_temporary(path: Path) -> bool:
    """Whether this is such a name: what a killed process left."""
    return _TOKEN.fullmatch(path.name) is not None


def temporaries_beside(path: Path) -> list[Path]:
    """What killed processes left that wrote to this path."""
    own = f".{path.stem}."
    return [
        other
        for other in path.parent.iterdir()
        if is_temporary(other) and other.name.startswith(own) and other.suffix == (path.suffix or other.suffix)
    ]
