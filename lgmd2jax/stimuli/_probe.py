"""What a renderer would show, without drawing it: the units of its arguments and its window of time."""

import contextvars
import dataclasses
from collections.abc import Callable
from typing import Any

from lgmd2jax._eye import Eye


@dataclasses.dataclass
class Probe:
    """What became known before the first frame: units by argument, start and end in ms (None for no window)."""

    units: dict[str, str] = dataclasses.field(default_factory=dict)
    window: tuple[float, float] | None = None


class _KnownError(Exception):
    """Ends a probe: what follows would be drawing."""


_probe: contextvars.ContextVar[Probe | None] = contextvars.ContextVar("probe", default=None)


def probe(renderer: Callable, eye: Eye, **arguments: Any) -> Probe:
    """Check the arguments of a renderer as a call does, and learn what they mean, at no cost.

    **Raises:** `ValueError` as the renderer.
    """
    found = Probe()
    token = _probe.set(found)
    try:
        renderer(eye, **arguments)
    except _KnownError:
        pass
    finally:
        _probe.reset(token)
    return found


def note_unit(name: str, unit: str) -> None:
    """Tell a probe the unit of an argument."""
    if (found := _probe.get()) is not None:
        found.units.setdefault(name, unit.strip("()"))


def note_window(start: float | int, end: float | int) -> None:
    """Tell a probe the window, which ends it."""
    if (found := _probe.get()) is not None:
        found.window = (start, end)
        raise _KnownError
