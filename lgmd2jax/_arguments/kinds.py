"""The kinds of values that an annotation allows: how each is known, and what an error asks for."""

import collections.abc
import contextlib
import functools
import inspect
import os
import types
import typing
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeVar

import jax
import jaxtyping
import numpy as np
from typing_extensions import TypeAliasType

from lgmd2jax._arguments.units import has_unit
from lgmd2jax._types import Key


class Kind(NamedTuple):
    """Something that an argument may be.

    - `holds`: how it is known. `wanted`: what an error asks for. `choices`: the names of which it is one.
    - `elements`: what each element of it may be, where it has some.
    """

    holds: Callable[[Any], bool]
    wanted: str = ""
    choices: tuple = ()
    elements: "tuple[Kind, ...]" = ()


class _UnsaidError(Exception):
    """An annotation does not say what may be given."""


@functools.cache
def kinds_of(function: Callable) -> dict[str, tuple[Kind, ...]]:
    """What each argument may be, by name; those whose annotation does not say are left out."""
    plain, kinds = inspect.unwrap(function), {}
    for name, annotation in plain.__annotations__.items():
        with contextlib.suppress(_UnsaidError):
            kinds[name] = _kinds(annotation, plain.__globals__)
    return kinds


def _kinds(annotation: Any, names: Mapping[str, Any]) -> tuple[Kind, ...]:
    parts = list(_parts(annotation, names))
    if Path in parts or os.PathLike in parts:
        parts = [part for part in parts if part is not str]
    if float in parts:
        parts = [part for part in parts if part not in (bool, int, complex)]
    return tuple(_kind_of(part, names) for part in parts)


def _parts(annotation: Any, names: Mapping[str, Any]) -> Iterator[Any]:
    """The single kinds that an annotation allows: aliases, unions and forward references taken apart."""
    if isinstance(annotation, str):
        try:
            annotation = eval(annotation, dict(names))
        except NameError:  # a type of an extra, which only type checkers import
            raise _UnsaidError from None
    if annotation is Key:
        raise _UnsaidError  # `check_key` knows more
    if isinstance(annotation, TypeAliasType):
        yield from _parts(annotation.__value__, names)
    elif isinstance(annotation, TypeVar):
        yield from _parts(annotation.__bound__ or Any, names)
    elif typing.get_origin(annotation) in (typing.Union, types.UnionType):
        for part in typing.get_args(annotation):
            yield from _parts(part, names)
    elif typing.get_origin(annotation) is typing.Annotated and not isinstance(annotation.__metadata__[0], str):
        yield from _parts(typing.get_args(annotation)[0], names)
    else:
        yield annotation


def _kind_of(part: Any, names: Mapping[str, Any]) -> Kind:
    origin = typing.get_origin(part) or part
    if origin is Literal:
        choices = typing.get_args(part)
        return Kind(lambda value: _is_one_of(value, choices), choices=choices)
    if origin is typing.Annotated:
        kind, wanted = typing.get_args(part)
        kinds = _kinds(kind, names)
        elements = tuple(element for each in kinds for element in each.elements)
        return Kind(lambda value: any(each.holds(value) for each in kinds), wanted, elements=elements)
    if part in _SIMPLE:
        return _SIMPLE[part]
    if isinstance(part, type) and issubclass(part, (jaxtyping.AbstractArray, np.generic)):
        return _ARRAY if getattr(part, "dim_str", "") else _NUMBER
    if origin is type:
        base = typing.get_args(part)[0]
        return Kind(lambda value: isinstance(value, type) and issubclass(value, base), f"a class of {base.__name__}")
    if origin in (os.PathLike, Path):
        return Kind(lambda value: isinstance(value, os.PathLike) or (isinstance(value, str) and value != ""), "a path")
    if origin is collections.abc.Callable:
        return Kind(callable, "a function")
    if isinstance(origin, type) and issubclass(origin, Mapping):
        elements = _elements(typing.get_args(part)[1:], names)
        return Kind(lambda value: isinstance(value, Mapping), "a dict", elements=elements)
    if origin in (list, tuple, Sequence, Collection, Iterable):
        return _sequence_of(typing.get_args(part), names)
    if isinstance(origin, type) and origin not in (Any, object, np.ndarray, jax.Array):
        article = "an" if origin.__name__[0] in "AEIO" else "a"
        wanted = _WANTED.get(origin.__name__, f"{article} {origin.__name__}")
        return Kind(lambda value: isinstance(value, origin) and not isinstance(value, type), wanted)
    raise _UnsaidError


def _sequence_of(elements: tuple, names: Mapping[str, Any]) -> Kind:
    if elements in ((str,), (str, ...)):
        return NAMES
    if elements and typing.get_origin(elements[0]) is Sequence:
        return Kind(_is_sequence, "a list of lists")  # what they hold, their taker knows
    if len({*elements} - {...}) > 1:  # what the unlike parts are, their taker knows
        count = len(elements)
        return Kind(lambda value: isinstance(value, tuple) and len(value) == count, f"a tuple of {count} parts")
    within = _elements(elements, names)
    return Kind(_is_sequence, "a list of numbers" if _NUMBER in within else "a list", elements=within)


def _elements(annotations: tuple, names: Mapping[str, Any]) -> tuple[Kind, ...]:
    """What each element may be, where the annotations are one and say it."""
    with contextlib.suppress(_UnsaidError):
        if len(alike := {*annotations} - {...}) == 1:
            return _kinds(alike.pop(), names)
    return ()


def _is_one_of(value: Any, choices: tuple) -> bool:
    return isinstance(value, tuple({type(choice) for choice in choices})) and value in choices


def _is_sequence(value: Any) -> bool:
    return isinstance(value, Iterable) and not isinstance(value, (str, bytes, Mapping))


def _are_names(value: Any) -> bool:
    return _is_sequence(value) and (not isinstance(value, Collection) or all(isinstance(each, str) for each in value))


def _is_number(value: Any, kinds: str = "iufV") -> bool:
    """Also one that JAX traces."""
    if isinstance(value, (bool, str)) or has_unit(value):
        return False
    dtype = getattr(value, "dtype", None)
    return isinstance(value, (int, float)) or (np.ndim(value) == 0 and getattr(dtype, "kind", "none") in kinds)


def _is_whole(value: Any) -> bool:
    return _is_number(value, "iu") and not isinstance(value, float)


def _is_array(value: Any) -> bool:
    """Numbers, or lists of them. What is within lists is looked at where they become an array."""
    dtype = getattr(value, "dtype", None)
    if dtype is None:
        return _is_sequence(value) and not has_unit(value)
    return not has_unit(value) and np.ndim(value) > 0 and getattr(dtype, "kind", "f") in "iufbV"  # V is bfloat16's


_NUMBER = Kind(_is_number, "a number")
_ARRAY = Kind(_is_array, "an array of numbers")
NAMES = Kind(_are_names, "a tuple of names")
_SIMPLE = {
    types.NoneType: Kind(lambda value: value is None),
    None: Kind(lambda value: value is None),
    str: Kind(lambda value: isinstance(value, str), "text"),
    bool: Kind(lambda value: isinstance(value, (bool, np.bool_)), "True or False"),
    int: Kind(_is_whole, "a whole number"),
    float: _NUMBER,
}
# What an error asks for where the name of the class says little.
_WANTED = {
    "AbstractNetwork": "a model, such as lgmd2jax.LGMD2()",
    "LGMD2": "a model, such as lgmd2jax.LGMD2()",
    "Free": "which parameters may change, such as Free(k=None)",
    "AnyTarget": "a target, such as a Target",
}
