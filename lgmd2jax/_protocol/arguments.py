"""The keyword arguments of a renderer, made from a table whose form is checked."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from lgmd2jax._words import within
from lgmd2jax.stimuli import BACKGROUNDS, DISTANCES
from lgmd2jax.stimuli._keywords import keywords
from lgmd2jax.stimuli._units import parts_of

_KINDS = {**BACKGROUNDS, **DISTANCES}


def arguments(callee: Callable, table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """What a table holds, as the keyword arguments of a renderer or of the class of an object that it takes.

    A sub-table with a `kind` becomes the background or the distance of that kind. An image that lies in `folder` is
    found there.

    **Raises:** `ValueError` for what makes no such object.
    """
    known = keywords(callee)
    return {key: _value(key, value, known[key].annotation, folder) for key, value in table.items()}


def located(path: str, folder: Path) -> str:
    """The path as seen from `folder`, where a file lies there, else as it is."""
    return str(folder / path) if (folder / path).is_file() else path


def _value(key: str, value: Any, annotation: Any, folder: Path) -> Any:
    if isinstance(value, Mapping):
        return dict(value) if key == "where" else _object(key, value, folder)
    if isinstance(value, list):
        return tuple(tuple(part) if isinstance(part, list) else part for part in value)
    if key == "image":
        return located(value, folder)
    if isinstance(value, int) and not isinstance(value, bool) and float in parts_of(annotation):
        return float(value)
    return value


def _object(key: str, table: Mapping[str, Any], folder: Path) -> Any:
    """The background or the distance that a sub-table describes."""
    kind = _KINDS[table["kind"]]
    with within(key):
        return kind(**arguments(kind, {name: value for name, value in table.items() if name != "kind"}, folder))
