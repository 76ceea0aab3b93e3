"""The form of a table that gives the keyword arguments of a function, or the fields of a class: their annotations."""

import functools
import inspect
import typing
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pydantic import BaseModel, Field

from lgmd2jax._schemas.parts import Number, Text, Truth, Whole, by_key, either, is_list, names, table
from lgmd2jax.stimuli import BACKGROUNDS, DISTANCES
from lgmd2jax.stimuli._keywords import keywords
from lgmd2jax.stimuli._units import Unit, parts_of

_OBJECTS = (BACKGROUNDS, DISTANCES)
Wrap = Callable[[Any], Any]


def alone(kind: Any) -> Any:
    """A value that is no axis."""
    return kind


def fields_of(callee: Any, wrap: Wrap = alone, deep: Wrap = alone) -> dict[str, Any]:
    """The type of each keyword in a document, for `table`; one without a default must be given.

    **Arguments:** `wrap`: what a value may be besides, such as an axis. `deep`: the same within tables.
    """
    declared = {field.name: field.type for field in getattr(callee, "__dataclass_fields__", {}).values()}
    fields = {}
    for name, keyword in keywords(callee).items():
        annotation = declared.get(name, keyword.annotation)
        unit = next((part.name for part in parts_of(annotation) if isinstance(part, Unit)), None)
        default = ... if keyword.default is keyword.empty else None
        fields[name] = (wrap(kind_of(annotation, deep)), Field(default, description=unit))
    return fields


def kind_of(annotation: Any, deep: Wrap) -> Any:
    """What stands in a document for a value of this annotation: a number, a text, a truth value, a table, a list."""
    parts = [part for part in parts_of(annotation) if part is not type(None)]
    origins = {typing.get_origin(choice) for choice in (annotation, *typing.get_args(annotation))}
    dimensions = {len(part.dims) for part in parts if hasattr(part, "dims")}
    texts = [part for part in parts if isinstance(part, str)]
    if objects := next((kinds for kinds in _OBJECTS if any(_holds(kinds, part) for part in parts)), {}):
        tables = by_key("kind", {name: _object(name, kind, deep) for name, kind in objects.items()})
        return either(_is_table, {"value": Number, "table": tables}) if float in parts else tables
    if Mapping in origins:
        return dict[Text, either(_is_text, {"value": Number, "text": Text})]
    if Sequence in origins:
        return _list_kind(annotation, deep)
    if texts:
        return names(texts)
    if 2 in dimensions:
        return Text  # the path of an image
    if 1 in dimensions:
        return list[Number]
    if 0 in dimensions or float in parts:
        return Number
    return Truth if parts == [bool] else Whole if int in parts else Text


def _list_kind(annotation: Any, deep: Wrap) -> Any:
    """A list, or also a single value where the annotation allows one."""
    choices = typing.get_args(annotation)
    sequence = next(choice for choice in (annotation, *choices) if typing.get_origin(choice) is Sequence)
    many = list[kind_of(typing.get_args(sequence)[0], deep)]
    single = [choice for choice in choices if choice not in (sequence, type(None))]
    if annotation is sequence or not single:
        return many
    return either(is_list, {"value": kind_of(single[0], deep), "list": many})


def _is_table(content: Any) -> str:
    return "table" if isinstance(content, Mapping) else "value"


def _is_text(content: Any) -> str:
    return "text" if isinstance(content, str) else "value"


def _holds(kinds: Mapping[str, type], part: Any) -> bool:
    return inspect.isclass(part) and any(issubclass(kind, part) for kind in kinds.values())


@functools.cache
def _object(name: str, kind: type, deep: Wrap) -> type[BaseModel]:
    return table(kind.__name__, {"kind": (names([name]), ...)} | fields_of(kind, deep, deep))
