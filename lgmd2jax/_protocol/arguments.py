"""The keyword arguments of a renderer, read from a table of plain data and checked against its signature."""

import difflib
import inspect
import typing
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from lgmd2jax._words import nearest
from lgmd2jax.stimuli import BACKGROUNDS, DISTANCES
from lgmd2jax.stimuli._units import parts_of

_KINDS = {**BACKGROUNDS, **DISTANCES}


def arguments(callee: Callable, table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """What a table holds, as the keyword arguments of a renderer or of the class of an object that it takes.

    Numbers, text and lists stay what they are; a sub-table with a `kind` becomes the background or the distance of that
    kind. An image that lies in `folder` is found there.

    **Raises:** `ValueError` for a key that the callee does not take and for a value of another type.
    """
    known = keywords(callee)
    check_keys(table, known)
    return {key: _value(key, value, known[key].annotation, folder) for key, value in table.items()}


def keywords(callee: Callable) -> dict[str, inspect.Parameter]:
    """The keywords that a renderer takes, or the fields of a class, by name."""
    every = inspect.signature(callee).parameters.items()
    return {
        name: parameter
        for name, parameter in every
        if parameter.kind is parameter.KEYWORD_ONLY or inspect.isclass(callee)
    }


def check_keys(table: Mapping[str, Any], known: Collection[str]) -> None:
    """Raise `ValueError` for the first key that is not known, with the nearest that is."""
    for key in table:
        if key not in known:
            likeliest = max(known, key=lambda name: difflib.SequenceMatcher(None, key, name).ratio())
            raise ValueError(f"unknown key {key!r}; did you mean {likeliest!r}?")


def section(table: Mapping[str, Any], key: str, known: Collection[str] | None = None) -> dict[str, Any]:
    """The sub-table of a key, empty where there is none.

    **Raises:** `ValueError` for what is no table, and for a key in it that is not `known`.
    """
    part = table.get(key, {})
    if not isinstance(part, dict):
        raise ValueError(f"{key} is {part!r}; write it as a table [{key}]")
    if known is not None:
        check_keys(part, known)
    return part


def check_complete(table: Mapping[str, Any], callee: Callable) -> None:
    """Raise `ValueError` for the first keyword without a default that the table lacks."""
    for name, parameter in keywords(callee).items():
        if parameter.default is parameter.empty and name not in table:
            raise ValueError(f"{name} is missing")


def located(path: str, folder: Path) -> str:
    """The path as seen from `folder`, where a file lies there, else as it is."""
    return str(folder / path) if (folder / path).is_file() else path


def _value(key: str, value: Any, annotation: Any, folder: Path) -> Any:
    origins = {typing.get_origin(choice) for choice in (annotation, *typing.get_args(annotation))}
    if Mapping in origins or (Sequence in origins and isinstance(value, list)):
        return _collection(key, value, annotation, Mapping if Mapping in origins else Sequence)
    allowed = tuple(parts_of(annotation))
    if isinstance(value, Mapping):
        return _object(key, value, allowed, folder)
    if Any in allowed:  # the field of an object that converts and checks by itself
        return located(value, folder) if key == "image" and isinstance(value, str) else value
    if allowed == (bool,):
        if not isinstance(value, bool):
            raise ValueError(f"{key} is {value!r}; give true or false")
        return value
    text = str in allowed or any(isinstance(choice, str) for choice in allowed)
    if text and isinstance(value, str):
        return value
    if float in allowed and isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    if int in allowed and isinstance(value, int) and not isinstance(value, bool):
        return value
    wanted = "a text" if text else "a number" if float in allowed else "a whole number" if int in allowed else "a table"
    raise ValueError(f"{key} is {value!r}; give {wanted}")


def _collection(key: str, value: Any, annotation: Any, kind: type) -> Any:
    """A table of texts and numbers, or a list of texts or of numbers."""
    of_numbers = str not in parts_of(annotation)
    if kind is Sequence and of_numbers and _all_numbers(value):
        return tuple(tuple(part) if isinstance(part, list) else part for part in value)
    if kind is Sequence and not of_numbers and all(isinstance(part, str) for part in value):
        return tuple(value)
    plain = isinstance(value, Mapping) and all(isinstance(element, (str, int, float)) for element in value.values())
    if kind is Mapping and plain:
        return dict(value)
    wanted = f"a list of {'numbers' if of_numbers else 'texts'}" if kind is Sequence else "a table of texts and numbers"
    raise ValueError(f"{key} is {value!r}; give {wanted}")


def _all_numbers(value: Any) -> bool:
    """Whether it is a number, or a list of numbers or of such lists."""
    if isinstance(value, list):
        return all(map(_all_numbers, value))
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _object(key: str, table: Mapping[str, Any], allowed: tuple, folder: Path) -> Any:
    """The background or the distance that a sub-table describes."""
    kinds = {
        name: kind
        for name, kind in _KINDS.items()
        if any(inspect.isclass(choice) and issubclass(kind, choice) for choice in allowed)
    }
    if not kinds:
        raise ValueError(f"{key} is the table {dict(table)}; give a plain value")
    if table.get("kind") not in kinds:
        raise ValueError(f"{key} has kind {table.get('kind')!r}; choose {nearest(table.get('kind', ''), kinds)}")
    kind = kinds[table["kind"]]
    fields = {name: value for name, value in table.items() if name != "kind"}
    try:
        check_complete(fields, kind)
        return kind(**arguments(kind, fields, folder))
    except ValueError as error:
        raise ValueError(f"{key}: {error}") from error
