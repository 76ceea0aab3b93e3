"""What makes a function a family of stimuli."""

import dataclasses
import functools
import inspect
import types
import typing
from collections.abc import Callable, Mapping
from typing import Any, ParamSpec

import jax
import jax.numpy as jnp
import numpy as np

from lgmd2jax._arguments.checked import bound
from lgmd2jax._eye import Eye
from lgmd2jax._types import Scalar, Times
from lgmd2jax.stimuli._stimulus import Sketch, Stimulus
from lgmd2jax.stimuli._units import units_of

P = ParamSpec("P")

FAMILIES: dict[str, Callable[..., Stimulus]] = {}
"""The families of stimuli by the names that protocols, sweeps and `strongest_stimulus` give."""
_SKETCHES: dict[Callable[..., Stimulus], Callable[..., Sketch]] = {}

# Arguments that say the same in other units. The first has the default, which the others replace.
_ALTERNATIVES = (
    ("l_over_v", "growth", "growth_px", "distance"),
    ("contrast", "level"),
    ("check_contrast", "check_level"),
    ("speed", "speed_px", "speed_cm_s"),
    ("size", "size_px", "size_cm"),
    ("width", "width_px"),
    ("start", "start_px"),
    ("stop", "stop_px"),
    ("spatial_frequency", "cycles"),
)
_WINDOW = {"start_ms", "end_ms"}
_NUMBERS = (int, float, np.number, np.ndarray, jax.Array)


def family(describe: Callable[P, Sketch]) -> Callable[P, Stimulus]:
    """A renderer that protocols know by name, whose stimuli carry that name and the numbers that they show.

    What does not depend on a traced value is computed at once, also inside of a jitted function: so the window can
    follow from numbers, and numbers can be checked.

    **Raises:** `ValueError`, when called, for what is no eye, for an argument that it does not take, and for two that
    say the same.
    """
    signature = inspect.signature(describe)

    @functools.wraps(describe)
    def render(*args: P.args, **kwargs: P.kwargs) -> Stimulus:
        arguments = _without_replaced_defaults(bound(describe.__name__, signature, args, kwargs))
        if not isinstance(arguments["eye"], Eye):
            raise ValueError(f"eye is {arguments['eye']!r:.60}; give an Eye")
        with jax.ensure_compile_time_eval():
            time, draw = describe(*args, **kwargs)
            frames, courses = draw()
            return Stimulus(frames, arguments["eye"].fps, time, describe.__name__, _numbers(arguments), courses)

    shown = [it.replace(annotation=_Shown(it.annotation)) for it in signature.parameters.values()]
    render.__dict__["__signature__"] = signature.replace(parameters=shown, return_annotation=_Shown(Stimulus))
    FAMILIES[describe.__name__], _SKETCHES[render] = render, describe
    return render


@dataclasses.dataclass(frozen=True)
class _Shown:
    """A type as `help` is to show it, by bare names. The type itself stands with the wrapped function."""

    kind: Any

    def __repr__(self) -> str:
        if typing.get_origin(self.kind) in (typing.Union, types.UnionType):
            return " | ".join(repr(_Shown(part)) for part in typing.get_args(self.kind))
        return "None" if self.kind is types.NoneType else getattr(self.kind, "__name__", repr(self.kind))


def _without_replaced_defaults(arguments: inspect.BoundArguments) -> dict[str, Any]:
    """All arguments by name, but defaults that an argument in another unit replaces."""
    names = {name for name, value in arguments.arguments.items() if value is not None}
    arguments.apply_defaults()
    values = dict(arguments.arguments)
    for group in _ALTERNATIVES:
        chosen = [name for name in group if name in names]
        if len(chosen) > 1:
            raise ValueError(f"{chosen[0]} and {chosen[1]} are both given; they say the same, so give one")
        if chosen and chosen[0] != group[0]:
            values.pop(group[0], None)
    return values


def _numbers(arguments: Mapping[str, Any]) -> dict[str, Scalar]:
    return {
        name: jnp.asarray(value, dtype=float)
        for name, value in arguments.items()
        if isinstance(value, _NUMBERS) and name not in _WINDOW
    }


def outline(renderer: Callable[..., Stimulus], eye: Eye, **arguments: Any) -> tuple[Times, dict[str, str]]:
    """The times of what a renderer shows, and the units of its arguments; a family is not drawn for it.

    What another renderer shows is drawn. If that is a family's, arguments of the same names have the same units.

    **Raises:** `ValueError` as the renderer.
    """
    with jax.ensure_compile_time_eval():
        if renderer in _SKETCHES:
            return _SKETCHES[renderer](eye, **arguments).time, units_of(renderer)
        stimulus = renderer(eye, **arguments)
    return stimulus.time, units_of(FAMILIES.get(stimulus.name, renderer))
