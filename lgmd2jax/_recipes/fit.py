"""A recipe: what to fit to what, read from a TOML file."""

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jax
import numpy as np

from lgmd2jax._characterise import characterise
from lgmd2jax._files.catalogue import beside
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._protocol.protocol import load_protocol
from lgmd2jax._targets.observation import Observation
from lgmd2jax._words import nearest, within
from lgmd2jax.fitting import Fit, Free, fit
from lgmd2jax.fitting._conditions import Rendered, render
from lgmd2jax.fitting._law_fit import check_approaches
from lgmd2jax.fitting._sections import free_of, network_of
from lgmd2jax.fitting._validation import check_no_bands, leave_one_out


@dataclasses.dataclass(frozen=True)
class Recipe:
    """A fit to be made: the model, what is free, and the conditions with their targets.

    - `profile`: parameters whose interval is also found by profile likelihood.
    - `samples`: how many draws of the posterior to take; 0 for none.
    - `leave_one_out`: whether to fit anew without each condition and to predict it.
    - `looming_law`: whether to hold the fit against eta, fitted to the same rates.
    - `truth`: the values that are known to be right, of a twin.
    - `properties`: whether to hand over, of the candidates, the one that holds most of the 22 response properties.
    - `table`: the file's content.
    """

    name: str
    model: AbstractNetwork
    observation: Observation
    free: Free
    pairs: tuple[Rendered, ...]
    solver: Mapping[str, Any]
    absolute_errors: bool | None
    profile: tuple[str, ...]
    samples: int
    leave_one_out: bool
    looming_law: bool
    truth: Mapping[str, float]
    properties: bool
    table: Mapping[str, Any]

    @property
    def seed(self) -> int:
        """Of the search's random points."""
        return self.solver.get("seed", 0)

    def run(self, progress: bool = False, memory=None, pairs=None) -> Fit:
        """Make the fit, by default to all conditions."""
        settings = {name: value for name, value in self.solver.items() if name != "seed"}
        return fit(
            self.model,
            self.pairs if pairs is None else pairs,
            self.free,
            key=jax.random.key(self.seed),
            observation=self.observation,
            absolute_errors=self.absolute_errors,
            progress=progress,
            memory=memory,
            choose=_properties_held if self.properties else None,
            **settings,
        )

    def predict_each(self, progress: bool = False) -> dict[str, float]:
        """R2 of each condition by a fit to the others."""
        return leave_one_out(lambda pairs: self.run(progress, pairs=pairs).predict, self.pairs)

    def digest(self) -> str:
        """A digest of all that the fit sees: recipe, stimuli and targets."""
        digest = hashlib.sha256(json.dumps(self.table, sort_keys=True).encode())
        for stimulus, targets in self.pairs:
            digest.update(np.asarray(stimulus.frames).tobytes() + np.asarray(stimulus.time).tobytes())
            for target in targets:
                digest.update(target.channel.encode() + np.asarray([target.values, target.scale]).tobytes())
                digest.update(b"" if target.upper is None else target.upper.tobytes())
        return digest.hexdigest()


def _properties_held(model: AbstractNetwork) -> float:
    return float(characterise(model).passed)


def fit_recipe(path: Path, table: dict[str, Any]) -> Recipe:
    """The recipe of a fit to curves that a TOML file, whose form is checked, holds; its stimuli are rendered.

    **Raises:** `ValueError`, which names the key, for what is not such a recipe; `FileNotFoundError`.
    """
    uncertainty, validation = table.get("uncertainty", {}), table.get("validation", {})
    free = free_of(table)
    profile, truth = tuple(uncertainty.get("profile", ())), table.get("truth", {})
    for key, names in (("uncertainty.profile", profile), ("truth", truth)):
        for name in names:
            if name not in free.names:
                raise ValueError(f"{key}: {name!r} is not free; choose {nearest(name, free.names)}")
    protocol = load_protocol(source := beside(path, table["protocol"]))
    with within(str(source)):
        pairs = tuple(render(protocol.conditions))
    if validation.get("looming_law", False):
        check_approaches(pairs)
    if validation.get("leave_one_out", False):
        check_no_bands(pairs)
    return Recipe(
        name=path.stem,
        model=network_of(table, protocol.conditions[0].eye),
        observation=Observation(**table.get("observation", {})),
        free=free,
        pairs=pairs,
        solver=table.get("solver", {}),
        absolute_errors=uncertainty.get("absolute_errors"),
        profile=profile,
        samples=uncertainty.get("samples", 0),
        leave_one_out=validation.get("leave_one_out", False),
        looming_law=validation.get("looming_law", False),
        truth=truth,
        properties=table.get("choice", {}).get("properties", False),
        table=table,
    )
