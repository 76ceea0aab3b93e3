"""What public functions and classes are given: of the kind that the annotation asks for, or an error in one line."""

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

from lgmd2jax._types import Key
from lgmd2jax._words import nearest

Checked = TypeVar("Checked", bound=Callable)
_CHOICES = 5  # names that a message offers


def checked(function: Checked) -> Checked:
    """The function, or the class, which refuses what its annotations exclude before it does anything.

    Kinds are looked at, not values: the range of a number, names that a table knows and the shape of an array remain
    its own matter. `Annotated[kind, "text"]` says in an error what to give.

    **Raises:** `ValueError`, when called, that names the argument, the value and the cure.
    """
    if not isinstance(function, type):
        return _checked(function, function.__name__)
    kind: Any = function
    kind.__init__ = _checked(kind.__init__, kind.__name__)
    return kind


def _checked(function: Callable, name: str) -> Any:
    signature = inspect.signature(function)

    @functools.wraps(function)
    def call(*args, **kwargs):
        try:
            given = signature.bind(*args, **kwargs).arguments
        except TypeError as error:
            raise ValueError(_misfit(name, signature, kwargs, error)) from None
        for argument, value in given.items():
            _check(argument, value, signature.parameters[argument], function)
        return function(*args, **kwargs)

    return call


def _misfit(name: str, signature: inspect.Signature, kwargs: Mapping[str, Any], error: TypeError) -> str:
    known = [argument for argument in signature.parameters if argument not in ("self", "cls")]
    for unknown in kwargs:
        if unknown not in known:
            return f"{name} takes no {unknown!r}" + (f"; choose {nearest(unknown, known, _CHOICES)}" if known else "")
    return f"{name}: {error}"


def _check(name: str, value: Any, parameter: inspect.Parameter, function: Callable) -> None:
    kinds = _kinds_of(function).get(name, ())
    if not kinds:
        return
    values = {name: value}
    if parameter.kind is parameter.VAR_POSITIONAL:
        values = {f"{name}[{place}]": each for place, each in enumerate(value)}
    elif parameter.kind is parameter.VAR_KEYWORD:
        values = value
    for place, each in values.items():
        _refuse(place, each, kinds)


class _Kind(NamedTuple):
    """Something that an argument may be.

    - `holds`: how it is known. `wanted`: what an error asks for. `choices`: the names of which it is one.
    - `elements`: what each element of it may be, where it has some.
    """

    holds: Callable[[Any], bool]
    wanted: str = ""
    choices: tuple = ()
    elements: "tuple[_Kind, ...]" = ()


def _cure(value: Any, kinds: tuple[_Kind, ...]) -> str:
    wanted = dict.fromkeys(kind.wanted for kind in kinds if kind.wanted)
    choices = [choice for kind in kinds for choice in kind.choices]
    parts = [*wanted, *([nearest(str(value), choices)] if choices else [])]
    example = f", as ({value!r},)" if _NAMES in kinds and isinstance(value, str) else ""
    return f"{'give' if wanted else 'choose'} {' or '.join(parts)}{example}"


def _refuse(place: str, value: Any, kinds: tuple[_Kind, ...]) -> None:
    holding = next((kind for kind in kinds if kind.holds(value)), None)
    if holding is None:
        raise ValueError(f"{place} is {_shown(value)}; {_cure(value, kinds)}")
    if holding.elements and (_has_elements(value)):
        for key, element in value.items() if isinstance(value, Mapping) else enumerate(value):
            _refuse(f"{place}[{key!r}]", element, holding.elements)


def _has_elements(value: Any) -> bool:
    return isinstance(value, (list, tuple, Mapping)) or (isinstance(value, np.ndarray) and value.dtype.hasobject)


class _UnsaidError(Exception):
    """An annotation does not say what may be given."""


@functools.cache
def _kinds_of(function: Callable) -> dict[str, tuple[_Kind, ...]]:
    """What each argument may be, by name; those whose annotation does not say are left out."""
    plain, kinds = inspect.unwrap(function), {}
    for name, annotation in plain.__annotations__.items():
        with contextlib.suppress(_UnsaidError):
            kinds[name] = _kinds(annotation, plain.__globals__)
    return kinds


def _kinds(annotation: Any, names: Mapping[str, Any]) -> tuple[_Kind, ...]:
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


def _kind_of(part: Any, names: Mapping[str, Any]) -> _Kind:
    origin = typing.get_origin(part) or part
    if origin is Literal:
        choices = typing.get_args(part)
        return _Kind(lambda value: _is_one_of(value, choices), choices=choices)
    if origin is typing.Annotated:
        kind, wanted = typing.get_args(part)
        kinds = _kinds(kind, names)
        return _Kind(lambda value: any(each.holds(value) for each in kinds), wanted)
    if part in _SIMPLE:
        return _SIMPLE[part]
    if isinstance(part, type) and issubclass(part, (jaxtyping.AbstractArray, np.generic)):
        dimensions = getattr(part, "dim_str", None)
        return _ARRAY if dimensions else _NUMBER
    if origin is type:
        base = typing.get_args(part)[0]
        return _Kind(lambda value: isinstance(value, type) and issubclass(value, base), f"a class of {base.__name__}")
    if origin in (os.PathLike, Path):
        return _Kind(lambda value: isinstance(value, (str, os.PathLike)), "a path")
    if origin is collections.abc.Callable:
        return _Kind(callable, "a function")
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return _Kind(
            lambda value: isinstance(value, Mapping),
            "a dict",
            elements=_elements((*typing.get_args(part), Any)[1:2], names),
        )
    if (
        isinstance(origin, type)
        and issubclass(origin, Iterable)
        and origin.__module__ in ("builtins", "collections.abc")
    ):
        element = (*typing.get_args(part), Any)[0]
        if typing.get_origin(element) is Sequence:
            return _Kind(_is_sequence, "a list of lists")  # what they hold, their taker knows
        if element is str:
            return _NAMES
        return _Kind(_is_sequence, "a list", elements=_elements(typing.get_args(part), names))
    if isinstance(origin, type) and origin not in (Any, object, np.ndarray, jax.Array):
        article = "an" if origin.__name__[0] in "AEIO" else "a"
        wanted = _WANTED.get(origin.__name__, f"{article} {origin.__name__}")
        return _Kind(lambda value: isinstance(value, origin) and not isinstance(value, type), wanted)
    raise _UnsaidError


def _elements(annotations: tuple, names: Mapping[str, Any]) -> tuple[_Kind, ...]:
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


def _is_number(value: Any, kinds: str = "iuf") -> bool:
    """Also one that JAX traces."""
    if isinstance(value, (bool, str)):
        return False
    return isinstance(value, (int, float)) or (np.ndim(value) == 0 and getattr(value, "dtype", _NONE).kind in kinds)


def _is_whole(value: Any) -> bool:
    return _is_number(value, "iu") and not isinstance(value, float)


def _is_array(value: Any) -> bool:
    """Numbers, or lists of them. What is within lists is looked at where they become an array."""
    dtype = getattr(value, "dtype", None)
    return _is_sequence(value) if dtype is None else np.ndim(value) > 0 and getattr(dtype, "kind", "f") in "iufbV"


def _shown(value: Any) -> str:
    if isinstance(value, type):
        return f"the class {value.__name__}"
    if hasattr(value, "dtype") and np.ndim(value):
        return f"an array of {value.dtype} with shape {value.shape}"
    text = repr(value)
    return f"a {type(value).__name__}" if "\n" in text or text.startswith("<") else f"{text:.60}"


_NONE = np.dtype("V")
_NUMBER = _Kind(_is_number, "a number")
_ARRAY = _Kind(_is_array, "an array of numbers")
_NAMES = _Kind(_are_names, "a tuple of names")
_SIMPLE = {
    types.NoneType: _Kind(lambda value: value is None),
    None: _Kind(lambda value: value is None),
    str: _Kind(lambda value: isinstance(value, str), "text"),
    bool: _Kind(lambda value: isinstance(value, (bool, np.bool_)), "True or False"),
    int: _Kind(_is_whole, "a whole number"),
    float: _NUMBER,
}
# What an error asks for where the name of the class says little.
_WANTED = {
    "AbstractNetwork": "a model, such as lgmd2jax.LGMD2()",
    "LGMD2": "a model, such as lgmd2jax.LGMD2()",
    "Free": "which parameters may change, such as Free(k=None)",
    "AnyTarget": "a target, such as a Target",
}
