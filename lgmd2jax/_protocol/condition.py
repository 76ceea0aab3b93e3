"""A condition of an experiment: a stimulus that can be rendered, with the curves that a response is compared with."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import jax

from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._targets.target import AnyTarget
from lgmd2jax._words import nearest, within
from lgmd2jax.stimuli import FAMILIES, Stimulus, camera
from lgmd2jax.stimuli._keywords import check_keywords


@checked
@dataclasses.dataclass(frozen=True)
class Condition:
    """One stimulus of a protocol.

    **Arguments:**

    - `name`: unique in its protocol.
    - `eye`: the sampling that it is rendered for.
    - `family`: the name of a renderer in `lgmd2jax.stimuli.FAMILIES`.
    - `parameters`: the renderer's keyword arguments; what is left out has the family's own default.
    - `camera`: what films the stimulus, as keyword arguments of `lgmd2jax.stimuli.camera` and a `seed`; None for none.
    - `targets`: the curves that a fit compares with: a `Target`, or what becomes one on the stimulus.

    **Raises:** `ValueError` for a family that there is not, and for a parameter that it does not take.
    """

    name: str
    eye: Eye
    family: str
    parameters: Mapping[str, Any]
    camera: Mapping[str, Any] | None = None
    targets: tuple[AnyTarget, ...] = ()

    def __post_init__(self):
        if self.family not in FAMILIES:
            raise ValueError(f"family is {self.family!r}; choose {nearest(self.family, FAMILIES)}")
        with within(f"condition {self.name!r}"):
            check_keywords(FAMILIES[self.family], self.parameters)

    def render(self) -> Stimulus:
        """The stimulus, under the name of the condition.

        **Raises:** `ValueError` that names the condition, where its parameters do not make a stimulus.
        """
        with within(f"condition {self.name!r}"):
            stimulus = FAMILIES[self.family](self.eye, **self.parameters)
            if self.camera is not None:
                settings = dict(self.camera)
                stimulus = camera(stimulus, jax.random.key(settings.pop("seed", 0)), **settings)
        return dataclasses.replace(stimulus, name=self.name)


@checked
@dataclasses.dataclass(frozen=True)
class Protocol:
    """The conditions of an experiment, in the order of their file, grids expanded."""

    name: str
    conditions: tuple[Condition, ...]
