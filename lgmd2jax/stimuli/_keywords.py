"""What functions and classes take by name: the arguments that documents give."""

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from lgmd2jax._words import nearest


def keywords(callee: Callable) -> dict[str, inspect.Parameter]:
    """The keywords that a function takes, or the fields of a class, by name."""
    every = inspect.signature(inspect.unwrap(callee)).parameters.items()
    return {
        name: parameter
        for name, parameter in every
        if parameter.kind is parameter.KEYWORD_ONLY or inspect.isclass(callee)
    }


def check_keywords(callee: Callable, table: Mapping[str, Any], *others: str) -> None:
    """Raise `ValueError` for the first key that neither the callee nor the `others` have, with the nearest one."""
    known = [*keywords(callee), *others]
    for key in table:
        if key not in known:
            raise ValueError(f"{key}: unknown key; did you mean {nearest(key, known, 1)}?")
