"""A recipe: what to fit to what, read from a TOML file, and its results, written into a folder."""

import csv
import dataclasses
import json
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from lgmd2jax import hard
from lgmd2jax._arguments import check_keys
from lgmd2jax._catalogue import locate
from lgmd2jax._export import save
from lgmd2jax._files import read_toml, replaced
from lgmd2jax._model import LGMD2
from lgmd2jax._parameters import preset, symbols
from lgmd2jax._protocol import Condition, load_protocol
from lgmd2jax.fitting import Fit, Free, Observation, Target, fit, read_target
from lgmd2jax.fitting._fit import TEMPERATURES, variance_explained
from lgmd2jax.stimuli import Stimulus


@dataclasses.dataclass(frozen=True)
class Recipe:
    """A fit to be made: the fixed model, what is free, and the conditions with their targets."""

    name: str
    model: LGMD2
    observation: Observation
    free: Free
    temperatures: tuple[float, ...]
    conditions: tuple[tuple[Stimulus, Target], ...]

    def run(self) -> Fit:
        """Make the fit."""
        return fit(self.model, self.conditions, self.observation, self.free, self.temperatures)


@dataclasses.dataclass(frozen=True)
class Curves:
    """One condition of a finished fit: the rates in spikes/s over the time in ms."""

    name: str
    time: np.ndarray
    target: Target
    soft: np.ndarray
    hard: np.ndarray

    @property
    def r2(self) -> dict[str, float]:
        """Variance explained by the soft and by the hard model."""
        return {kind: variance_explained(getattr(self, kind), self.target) for kind in ("soft", "hard")}


def load_recipe(source: str | Path) -> Recipe:
    """Read a recipe from a TOML file, or a shipped one by its bare name, and render its stimuli.

    **Raises:** `ValueError`, which names the file and the key, for what is not a recipe; `FileNotFoundError`.
    """
    path = locate(source, "fits")
    table = read_toml(path)
    try:
        return _recipe(path, table)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{path}: {error}") from error


def _recipe(path: Path, table: dict[str, Any]) -> Recipe:
    check_keys(table, ("protocol", "preset", "parameters", "observation", "free", "solver"))
    for key in ("protocol", "free"):
        if key not in table:
            raise ValueError(f"{key} is missing")
    fixed = table.get("parameters", {})
    check_keys(fixed, symbols())
    check_keys(table["free"], symbols())
    for limits in table["free"].values():
        check_keys(limits, ("low", "high"))
    check_keys(table.get("observation", {}), [field.name for field in dataclasses.fields(Observation)])
    check_keys(table.get("solver", {}), ("temperatures",))
    bounds = {
        name: (limits.get("low", symbols()[name].bounds[0]), limits.get("high", symbols()[name].bounds[1]))
        for name, limits in table["free"].items()
    }
    beside = path.parent / table["protocol"]
    protocol = load_protocol(beside if beside.is_file() else table["protocol"])
    return Recipe(
        name=path.stem,
        model=LGMD2(preset(table.get("preset", "lgmd2"), **fixed), eye=protocol.conditions[0].eye),
        observation=Observation(**table.get("observation", {})),
        free=Free(**bounds),
        temperatures=tuple(table.get("solver", {}).get("temperatures", TEMPERATURES)),
        conditions=tuple(_with_target(condition) for condition in protocol.conditions),
    )


def _with_target(condition: Condition) -> tuple[Stimulus, Target]:
    if len(condition.targets) != 1:
        raise ValueError(f"condition {condition.name!r} has {len(condition.targets)} targets; give it one")
    stimulus, target = condition.render(), condition.targets[0]
    for key in ("file", "column"):
        if key not in target:
            raise ValueError(f"condition {condition.name!r}: its target has no {key}")
    return stimulus, read_target(target["file"], target["column"], np.asarray(stimulus.time), target.get("sem"))


def write_results(
    recipe: Recipe, result: Fit, folder: Path, draw: Callable[[Path, list[Curves], str], None]
) -> list[Curves]:
    """Write model.json, curves.csv, fit.json and fit.png. The hard curves are those of model.json, read by `hard.py`.

    **Returns:** the curves of each condition. **Raises:** `ValueError` where the folder cannot be written to.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (
        replaced(folder / "model.json") as model_file,
        replaced(folder / "curves.csv") as curves_file,
        replaced(folder / "fit.json") as fit_file,
        replaced(folder / "fit.png") as figure_file,
    ):
        save(result.model, model_file)
        robot = hard.load(model_file)
        curves = [_curves(result, robot, *condition) for condition in recipe.conditions]
        _write_curves(curves_file, curves)
        summary = {
            "free": {
                name: {"value": float(getattr(result.model.parameters, name)), "low": low, "high": high}
                for name, (low, high) in recipe.free.bounds.items()
            },
            "observation": {
                field.name: getattr(result.observation, field.name) for field in dataclasses.fields(Observation)
            },
            "loss": result.loss,
            "solver": {"result": result.result, "steps": result.steps, "temperatures": recipe.temperatures},
            "r2": {curve.name: curve.r2 for curve in curves},
            "versions": {name: version(name) for name in ("lgmd2jax", "jax", "optimistix")},
        }
        fit_file.write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
        draw(figure_file, curves, recipe.name)
    return curves


def _curves(result: Fit, robot: hard.HardLGMD2, stimulus: Stimulus, target: Target) -> Curves:
    soft = result.soft(stimulus.frames, stimulus.fps).smp_adapted
    potential = robot(np.asarray(stimulus.frames), float(stimulus.fps)).smp_adapted
    rates = [np.asarray(result.observation(np.asarray(u), stimulus.time)) for u in (soft, potential)]
    return Curves(stimulus.name, np.asarray(stimulus.time), target, *rates)


def _write_curves(path: Path, curves: list[Curves]) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["condition", "time_ms", "target", "soft", "hard"])
        for curve in curves:
            for row in zip(curve.time, curve.target.values, curve.soft, curve.hard, strict=True):
                writer.writerow([curve.name, *(f"{value:.6g}" for value in row)])
