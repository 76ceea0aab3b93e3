"""Grids written as lists in a table, and names with placeholders for what varies in them."""

import itertools
import string
from collections.abc import Iterator, Mapping
from typing import Any


def expand(table: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """One table a grid point: every list is an axis, also within sub-tables, the first one written varies slowest.

    **Raises:** `ValueError` for an empty list.
    """
    choices = []
    for key, value in table.items():
        if isinstance(value, Mapping):
            choices.append(list(expand(value)))
        elif isinstance(value, list):
            if not value:
                raise ValueError(f"{key} is an empty list; give its values")
            choices.append(value)
        else:
            choices.append([value])
    for point in itertools.product(*choices):
        yield dict(zip(table, point, strict=True))


def fill(template: Any, values: Mapping[str, Any]) -> Any:
    """The template with the placeholders of all its strings filled, also within tables and lists.

    **Raises:** `ValueError` for a placeholder that nothing fills.
    """
    if isinstance(template, Mapping):
        return {key: fill(value, values) for key, value in template.items()}
    if isinstance(template, list):
        return [fill(value, values) for value in template]
    if not isinstance(template, str):
        return template
    try:
        return _ShortNumbers().vformat(template, (), values)
    except (KeyError, IndexError, AttributeError, TypeError) as error:
        known = ", ".join(f"{{{name}}}" for name in values)
        raise ValueError(f"a placeholder of {template!r} is not filled; the parameters are {known}") from error
    except ValueError as error:
        raise ValueError(f"{template!r} is not a format string: {error}") from error


class _ShortNumbers(string.Formatter):
    """Format strings in which a number without a format of its own is written by %g: 40.0 is "40"."""

    def format_field(self, value, format_spec):
        if isinstance(value, (int, float)) and not isinstance(value, bool) and not format_spec:
            return f"{value:g}"
        return super().format_field(value, format_spec)
