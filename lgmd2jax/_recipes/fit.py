"""A recipe: what to fit to what, read from a TOML file."""

import dataclasses
import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal

import jax
import numpy as np

from lgmd2jax._arguments.checked import checked
from lgmd2jax._characterise import characterise
from lgmd2jax._compute.finished_work import Memory, MemoryPart
from lgmd2jax._files.catalogue import beside, locate
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.parameters import symbols
from lgmd2jax._protocol.condition import Condition
from lgmd2jax._protocol.protocol import load_protocol
from lgmd2jax._targets.observation import Observation
from lgmd2jax._words import nearest, within
from lgmd2jax.fitting import Fit, Free, Profile, Supplement, fit
from lgmd2jax.fitting._animals import conditions_by_animal
from lgmd2jax.fitting._conditions import Rendered, render
from lgmd2jax.fitting._law_fit import check_approaches, compare_with_law
from lgmd2jax.fitting._search.descent import STOPPED
from lgmd2jax.fitting._sections import free_of, network_of
from lgmd2jax.fitting._validation import Pair, Predict, check_no_bands, leave_one_out, predicted_r2

Part = Callable[[Supplement], Supplement]  # adds what it computes


@dataclasses.dataclass(frozen=True)
class Recipe:
    """A fit to be made, as `load_recipe` reads it: the model, what is free, and the conditions with their targets.

    ```python
    recipe = lgmd.load_recipe("twin")
    fit = recipe.run(progress=True)
    lgmd.save_fit(fit, "mine")
    ```

    - `protocol`: the file of the conditions. `pairs`: these, rendered.
    - `profile`: parameters whose interval is also found by profile likelihood.
    - `samples`: how many draws of the posterior to take; 0 for none.
    - `leave_one_out`: whether to fit anew without each condition, or each `"family"` of them, and to predict it.
    - `looming_law`: whether to hold the fit against eta, fitted to the same rates.
    - `truth`: the values that are known to be right, of a twin.
    - `properties`: whether to hand over, of the candidates, the one that holds most of the 22 response properties.
    - `families`: of which family the stimulus of each condition is. `table`: the file's content.
    - `animals`: by name the conditions of each animal, by their numbers, where each is to have a fit of its own.
      `animal`: in the recipe of one such fit, the animal's name.
    """

    name: str
    protocol: Path
    model: AbstractNetwork
    observation: Observation
    free: Free
    pairs: tuple[Rendered, ...]
    solver: Mapping[str, Any]
    absolute_errors: bool | None
    profile: tuple[str, ...]
    samples: int
    leave_one_out: bool | Literal["family"]
    looming_law: bool
    truth: Mapping[str, float]
    properties: bool
    families: tuple[str, ...]
    table: Mapping[str, Any]
    animals: Mapping[str, Mapping[int, Rendered]] = dataclasses.field(default_factory=dict)
    animal: str = ""

    @property
    def seed(self) -> int:
        """The seed of the search's random points."""
        return self.solver.get("seed", 0)

    @checked
    def run(self, progress: bool = False, memory=None, pairs=None) -> Fit:
        """Make the fit.

        **Arguments:** `progress`, `memory`: as of `lgmd2jax.fit`. `pairs`: what to fit in place of the recipe's own
        `pairs`, such as some of them.

        **Raises:** as `lgmd2jax.fit`.
        """
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

    def each(self) -> dict[str, "Recipe"]:
        """The recipe of each animal, where the file asks for one fit an animal; else none."""
        return {
            animal: dataclasses.replace(
                self,
                name=f"{self.name}, {animal}",
                pairs=tuple(conditions.values()),
                families=tuple(self.families[number] for number in conditions),
                animals={},
                animal=animal,
            )
            for animal, conditions in self.animals.items()
        }

    @checked
    def predict_each(self, progress: bool = False) -> dict[str, float]:
        """R2 of each condition by a fit to the others, or to those of other families.

        **Raises:** `KeyboardInterrupt` on Ctrl-C, also where one of the fits would return its best so far.
        """
        return leave_one_out(lambda pairs: self._predictor(pairs, progress, None), self.pairs, self._groups)

    def further(self, fit: Fit, memory: Memory, progress: bool = False) -> dict[str, Part]:
        """What the recipe asks for beside the fit, by a few words: functions that each add a part to a supplement.

        **Arguments:** `memory`: of finished work, so that what was stopped goes on from there.
        """
        parts: dict[str, Part] = {}
        parts["the score test"] = partial(self._with_scores, fit)
        if self.looming_law:
            parts["the looming law"] = partial(self._with_law, fit)
        for name in self.profile:
            parts[f"the profile of {name}"] = partial(self._with_profile, fit, memory, name)
        if self.leave_one_out:
            for group in dict.fromkeys(self._groups):
                words = f"the prediction of {group!r} by a fit to the others"
                parts[words] = partial(self._with_prediction, memory, progress, group)
        return parts

    @property
    def _groups(self) -> tuple[str, ...]:
        """What is left out together: each condition by itself, or each family."""
        if self.leave_one_out == "family":
            return self.families
        return tuple(stimulus.name for stimulus, _ in self.pairs)

    def _with_scores(self, fit: Fit, extra: Supplement) -> Supplement:
        return dataclasses.replace(extra, scores=fit.score_test())

    def _with_law(self, fit: Fit, extra: Supplement) -> Supplement:
        law = compare_with_law(self.pairs, fit.curves, smoothing=float(fit.observation.smoothing))
        return dataclasses.replace(extra, looming_law=law)

    def _with_profile(self, fit: Fit, memory: Memory, name: str, extra: Supplement) -> Supplement:
        key = f"profile of {name}"
        if key not in memory:
            memory[key] = fit.profile(name).plain()
        return dataclasses.replace(extra, profiles={**extra.profiles, name: Profile.of(memory[key])})

    def _with_prediction(self, memory: Memory, progress: bool, group: str, extra: Supplement) -> Supplement:
        key = f"without {group}"
        if key not in memory:
            predictor = partial(self._predictor, progress=progress, memory=MemoryPart(memory, key))
            memory[key] = predicted_r2(predictor, self.pairs, self._groups, group)
        return dataclasses.replace(extra, left_out={**extra.left_out, **memory[key]})

    def _predictor(self, pairs: Sequence[Pair], progress: bool, memory: Memory | None) -> Predict:
        fit = self.run(progress, memory, pairs)
        if fit.result == STOPPED:  # its best so far would pass for the fit that was asked for
            raise KeyboardInterrupt
        return fit.predict

    @checked
    def with_mechanisms(self, *mechanisms: str) -> "Recipe":
        """The same fit of another circuit.

        What acts on nothing in that circuit is no longer free; what comes into play is, within its declared bounds.

        **Raises:** `ValueError` for mechanisms that do not exist, and for a network that has none.
        """
        if not isinstance(self.model, LGMD2):
            raise ValueError(f"mechanisms belong to an LGMD2, and {self.name} fits another network; leave them out")
        model = dataclasses.replace(self.model, mechanisms=mechanisms)
        free = {name: line for name, line in self.table["free"].items() if name not in model.unused}
        free |= {name: {} for name in symbols() if name in self.model.unused - model.unused}
        structure = self.table.get("structure", {}) | {"mechanisms": list(mechanisms)}
        table = {**self.table, "structure": structure, "free": free}
        profile = tuple(name for name in self.profile if name in free)
        truth = {name: value for name, value in self.truth.items() if name in free}
        return dataclasses.replace(self, model=model, free=free_of(table), profile=profile, truth=truth, table=table)

    def digest(self) -> str:
        """A digest of all that the fit sees: recipe, stimuli and targets."""
        digest = hashlib.sha256(json.dumps(self.table, sort_keys=True).encode())
        for stimulus, targets in self.pairs:
            digest.update(np.asarray(stimulus.frames).tobytes() + np.asarray(stimulus.time).tobytes())
            for target in targets:
                digest.update(target.channel.encode() + np.asarray([target.values, target.scale]).tobytes())
                digest.update(b"" if target.upper is None else target.upper.tobytes())
                digest.update(b"" if target.exposure is None else target.exposure.tobytes())
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
        animals = _animals(protocol.conditions) if "by" in table else {}
    if validation.get("looming_law", False):
        check_approaches(pairs)
    if validation.get("leave_one_out", False):
        check_no_bands(pairs)
    return Recipe(
        name=path.stem,
        protocol=locate(source, "stimuli"),
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
        families=tuple(condition.family for condition in protocol.conditions),
        table=table,
        animals=animals,
    )


def _animals(conditions: Sequence[Condition]) -> dict[str, dict[int, Rendered]]:
    """The conditions of each animal by their numbers, rendered."""
    return {
        animal: dict(zip((number for number, _ in pairs), render([pair for _, pair in pairs]), strict=True))
        for animal, pairs in conditions_by_animal(conditions).items()
    }
