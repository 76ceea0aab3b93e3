"""A document held against its schema; what is wrong is said in one line: the path of the key, the value, the cure."""

import re
import reprlib
from collections.abc import Iterator, Mapping
from typing import Any, Literal

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from lgmd2jax._words import nearest

_ABSENT = object()
_TOLD = 3  # errors in one line
_LONGEST = 60  # characters of a value
_WORDS = {
    "float_type": "must be a number",
    "finite_number": "must be a finite number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": "must be a text",
    "list_type": "must be a list",
    "tuple_type": "must be a list",
    "dict_type": "must be a table",
    "model_type": "must be a table",
    "model_attributes_type": "must be a table",
    "greater_than": "must be above {gt}",
    "greater_than_equal": "must be {ge} or more",
    "less_than": "must be below {lt}",
    "less_than_equal": "must be {le} or less",
    "too_short": "must hold {min_length} or more values",
    "too_long": "must hold {max_length} or fewer values",
    "string_too_short": "must not be empty",
    "invalid_key": "must have names as keys",
}
# Of each kind of document the keys that no other has, its name, and what shows one.
_KINDS = {
    "recipe": ({"protocol", "free", "solver", "family", "kind"}, "a recipe", "lgmd2jax fit --help"),
    "protocol": ({"condition"}, "a protocol of stimuli", "lgmd2jax stimuli --help"),
    "labels": ({"clip", "rendered"}, "a file of labelled clips", "lgmd2jax watch --help"),
}


def check_kind(document: Mapping[str, Any], wanted: Literal["recipe", "protocol", "labels"]) -> None:
    """Raise `ValueError` for a document of another kind, which has none of its own keys and some of the other's."""
    own, name, shows = _KINDS[wanted]
    for keys, other, _ in _KINDS.values():
        if keys & document.keys() and not own & document.keys():
            raise ValueError(f"it is {other}, not {name}; see {shows}")


def check(schema: TypeAdapter, document: Any) -> None:
    """Raise `ValueError` for a document that does not have the form of the schema.

    The message names up to three errors, each as `condition[2].error = -1: must be above 0`.
    """
    try:
        schema.validate_python(document)
    except ValidationError as error:
        errors = error.errors(include_url=False)
    else:
        return
    sentences = list(dict.fromkeys(_sentence(each, document) for each in errors))
    more = [f"and {len(sentences) - _TOLD} more"] if len(sentences) > _TOLD else []
    raise ValueError("; ".join([*sentences[:_TOLD], *more]))


def _sentence(error: ErrorDetails, document: Any) -> str:
    kind, context = error["type"], error.get("ctx", {})
    path = [*_steps(error["loc"], document), *context.get("path", ())]
    where = _written_path(path) or "document"
    value = _value(document, path)
    if value is _ABSENT:
        return f"{where} is missing; " + (f"choose {nearest('', context['known'])}" if "known" in context else "add it")
    return f"{where} = {_shown(value)}: {_cure(kind, path, value, context, error['msg'])}"


def _cure(kind: str, path: list[str | int], value: Any, context: dict[str, Any], message: str) -> str:
    name = str(path[-1]) if path else ""
    if "cure" in context:
        return context["cure"]
    if kind == "unknown_key":
        return f"unknown key; did you mean {nearest(name, context['known'], 1)}?"
    if kind == "float_type" and type(value) is int:
        return "is too large for a number"
    if kind == "list_type" and isinstance(value, dict):
        return f"must be a list; write each table under [[{name}]]"
    known = context.get("known") or re.findall(r"'([^']*)'", context.get("expected", ""))
    if known:
        return f"choose {nearest(str(value), known)}"
    if kind in _WORDS:
        return _WORDS[kind].format(**{name: _number(value) for name, value in context.items()})
    message = message.removeprefix("Value error, ")
    return message.replace("Input should be", "must be").replace("Input should", "must")


def _steps(location: tuple[str | int, ...], document: Any) -> Iterator[str | int]:
    """The keys of the document in a location of pydantic's, which also names the branch of a union, as `<axis>`."""
    for step in location:
        inside = isinstance(document, dict) and step in document
        inside = inside or (isinstance(document, list) and isinstance(step, int) and 0 <= step < len(document))
        if inside:
            document = document[step]  # pyright: ignore[reportArgumentType, reportCallIssue]
        elif isinstance(step, str) and step.startswith("<"):
            continue
        yield step


def _value(document: Any, path: list[str | int]) -> Any:
    for step in path:
        try:
            document = document[step]
        except (KeyError, IndexError, TypeError):
            return _ABSENT
    return document


def _written_path(path: list[str | int]) -> str:
    text = ""
    for step in path:
        if isinstance(step, int):
            text += f"[{step}]"
        else:
            text += "." * bool(text) + (step if re.fullmatch(r"[\w-]{1,60}", step) else _shown(step))
    return text


def _shown(value: Any) -> str:
    """A value on one line of bearable length, as documents write it."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    short = reprlib.Repr()
    short.maxstring = short.maxother = short.maxlong = _LONGEST
    text = short.repr(value)
    return text if len(text) <= 2 * _LONGEST else f"{text[: 2 * _LONGEST]}..."


def _number(value: Any) -> Any:
    return f"{value:g}" if isinstance(value, float) else value
