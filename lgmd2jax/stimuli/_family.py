"""What makes a function a family of stimuli."""

import dataclasses
import functools
import inspect
from collections.abc import Callable
from typing import ParamSpec

import jax
import jax.numpy as jnp
import numpy as np

from lgmd2jax.stimuli._stimulus import Stimulus

P = ParamSpec("P")

FAMILIES: dict[str, Callable[..., Stimulus]] = {}

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


def family(render: Callable[P, Stimulus]) -> Callable[P, Stimulus]:
    """A renderer that protocols know by name, whose stimuli carry that name and the numbers that they show.

    What does not hang on a traced value is computed at once, also inside of a jitted function: so the window can
    follow from numbers, and numbers can be checked.

    **Raises:** `ValueError`, when called, for two arguments that say the same.
    """
    signature = inspect.signature(render)

    @functools.wraps(render)
    def rendered(*args: P.args, **kwargs: P.kwargs) -> Stimulus:
        arguments = signature.bind(*args, **kwargs)
        given = {name for name, value in arguments.arguments.items() if value is not None}
        arguments.apply_defaults()
        shown = dict(arguments.arguments)
        for group in _ALTERNATIVES:
            said = [name for name in group if name in given and name in shown]
            if len(said) > 1:
                raise ValueError(f"{said[0]} and {said[1]} are both given; they say the same, so give one")
            if said and said[0] != group[0]:
                shown.pop(group[0], None)
        with jax.ensure_compile_time_eval():
            stimulus = render(*args, **kwargs)
            numbers = {
                name: jnp.asarray(value, dtype=float)
                for name, value in shown.items()
                if isinstance(value, _NUMBERS) and name not in _WINDOW
            }
        return dataclasses.replace(stimulus, name=render.__name__, parameters=numbers)

    FAMILIES[render.__name__] = rendered
    return rendered
