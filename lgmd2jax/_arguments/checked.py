"""A decorator of public functions and classes, which refuses in one line what their annotations exclude."""

import functools
import inspect
from collections.abc import Callable, Mapping
from typing import Any, TypeVar, cast

import numpy as np

from lgmd2jax._arguments.kinds import NAMES, Kind, kinds_of
from lgmd2jax._arguments.units import has_unit
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


def checked_names(function: Checked) -> Checked:
    """The function, which refuses arguments that it does not take; of what kind they are, it looks at by itself."""
    signature, plain = inspect.signature(function), cast(Any, function)

    @functools.wraps(function)
    def call(*args, **kwargs):
        try:
            return plain(*args, **kwargs)
        except TypeError:  # looked at only now, since a step of a model is called for every frame
            bound(plain.__name__, signature, args, kwargs)
            raise

    return cast(Any, call)


def bound(
    name: str, signature: inspect.Signature, args: tuple[Any, ...], kwargs: Mapping[str, Any]
) -> inspect.BoundArguments:
    """The arguments of a call, as `inspect.Signature.bind` gives them.

    **Raises:** `ValueError` with the nearest name for one that is not taken, and for one too many or too few.
    """
    try:
        return signature.bind(*args, **kwargs)
    except TypeError as error:
        raise ValueError(_misfit(name, signature, kwargs, error)) from None


def _checked(function: Callable, name: str) -> Any:
    signature = inspect.signature(function)

    @functools.wraps(function)
    def call(*args, **kwargs):
        kinds = kinds_of(function)
        for argument, value in bound(name, signature, args, kwargs).arguments.items():
            if argument in kinds:
                _check(value, signature.parameters[argument], kinds[argument])
        return function(*args, **kwargs)

    return call


def _misfit(name: str, signature: inspect.Signature, kwargs: Mapping[str, Any], error: TypeError) -> str:
    known = [argument for argument in signature.parameters if argument not in ("self", "cls")]
    for unknown in kwargs:
        if unknown not in known:
            return f"{name} takes no {unknown!r}" + (f"; choose {nearest(unknown, known, _CHOICES)}" if known else "")
    return f"{name}: {error}"


def _check(value: Any, parameter: inspect.Parameter, kinds: tuple[Kind, ...]) -> None:
    values = {parameter.name: value}
    if parameter.kind is parameter.VAR_POSITIONAL:
        values = {f"{parameter.name}[{place}]": each for place, each in enumerate(value)}
    elif parameter.kind is parameter.VAR_KEYWORD:
        values = value
    for place, each in values.items():
        _refuse(place, each, kinds)


def _cure(value: Any, kinds: tuple[Kind, ...]) -> str:
    wanted = dict.fromkeys(kind.wanted for kind in kinds if kind.wanted)
    choices = [choice for kind in kinds for choice in kind.choices]
    parts = [*wanted, *([nearest(str(value), choices)] if choices else [])]
    example = f", as ({value!r},)" if NAMES in kinds and isinstance(value, str) else ""
    return f"{'give' if wanted else 'choose'} {' or '.join(parts)}{example}"


def _refuse(place: str, value: Any, kinds: tuple[Kind, ...]) -> None:
    holding = next((kind for kind in kinds if kind.holds(value)), None)
    if holding is None:
        raise ValueError(f"{place} is {_shown(value)}; {_cure(value, kinds)}")
    if holding.elements and _has_elements(value):
        for key, element in value.items() if isinstance(value, Mapping) else enumerate(value):
            _refuse(f"{place}[{key!r}]", element, holding.elements)


def _has_elements(value: Any) -> bool:
    return isinstance(value, (list, tuple, Mapping)) or (isinstance(value, np.ndarray) and value.dtype.hasobject)


def _shown(value: Any) -> str:
    if isinstance(value, type):
        return f"the class {value.__name__}"
    if has_unit(value):
        return " ".join(f"{value!r:.60}".split())
    if hasattr(value, "dtype") and np.ndim(value):
        return f"an array of {value.dtype} with shape {value.shape}"
    text = repr(value)
    return f"a {type(value).__name__}" if "\n" in text or text.startswith("<") else f"{text:.60}"
