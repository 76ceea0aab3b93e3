"""What is structure of a network: values that are compiled in, counts of frames and choices."""

import dataclasses
from collections.abc import Callable
from typing import Any

import equinox as eqx

from lgmd2jax._arguments.checked import checked
from lgmd2jax._words import nearest

_MOST = 10_000  # of what counts; more would only fill the memory


@dataclasses.dataclass(frozen=True)
class Structure:
    """What a structural field declares of itself.

    - `least`: the smallest whole number that makes sense; None where the value is one of `choices`, or `several`.
    - `at_interval`: what becomes of it where frames last `ratio` times as long.
    """

    unit: str
    least: int | None = None
    choices: tuple[str, ...] = ()
    several: bool = False
    at_interval: Callable[[Any, float], Any] = lambda value, ratio: value

    def check(self, name: str, value) -> None:
        """Raise `ValueError` for a value that makes no sense."""
        if self.several:
            if not isinstance(value, tuple):
                raise ValueError(f"{name} is {value!r}; give a tuple of {', '.join(map(repr, self.choices))}")
            for each in value:
                if each not in self.choices:
                    raise ValueError(f"{name} has {each!r}; choose {nearest(each, self.choices)}")
                if value.count(each) > 1:
                    raise ValueError(f"{name} has {each!r} twice; name each once")
        elif self.least is None:
            if value not in self.choices:
                raise ValueError(f"{name} is {value!r}; choose {nearest(value, self.choices)}")
        elif not isinstance(value, int) or isinstance(value, bool) or not self.least <= value <= _MOST:
            raise ValueError(f"{name} is {value!r}; give a whole number of {self.unit}, {self.least} to {_MOST}")


@checked
def counts(default: int, unit: str, least: int, at_interval: Callable[[int, float], int] | None = None):
    """A field of a network that counts, such as the frames of a window: a whole number, compiled in and never fitted.

    ```python
    N_alarm: int = lgmd.counts(3, "spikes", least=1)
    ```

    **Arguments:** `unit`: what it counts, in the plural, for messages. `least`: the smallest number that makes sense.
    `at_interval`: a function of the number and a ratio, for frames that last `ratio` times as long; without one the
    number stays.
    """
    declared = Structure(unit, least) if at_interval is None else Structure(unit, least, at_interval=at_interval)
    return eqx.field(default=default, static=True, metadata={"structure": declared})


@checked
def one_of(default: str, choices: tuple[str, ...]):
    """A field of a network that is one of a few names, compiled in and never fitted.

    ```python
    low_pass: str = lgmd.one_of("exact", ("exact", "backward_euler"))
    ```
    """
    return eqx.field(default=default, static=True, metadata={"structure": Structure("", choices=choices)})


def some_of(choices: tuple[str, ...]):
    """A structural field that holds some of a few names, none by default."""
    return eqx.field(default=(), static=True, metadata={"structure": Structure("", choices=choices, several=True)})


def structure_fields(kind: type[eqx.Module]) -> dict[str, Structure]:
    """The structural fields of a network's class, by name."""
    every = {field.name: field.metadata.get("structure") for field in dataclasses.fields(kind)}
    return {name: declared for name, declared in every.items() if declared is not None}


def structure_of(network: eqx.Module) -> dict[str, Any]:
    """The structure of a network as plain values, by name."""
    return {name: getattr(network, name) for name in structure_fields(type(network))}
