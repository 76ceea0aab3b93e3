"""`lgmd2jax fit RECIPE` for a recipe of kind "alarms": from labelled clips to a model that a robot runs."""

import argparse
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tqdm import tqdm

from lgmd2jax._files.folder import check_folder
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.parameters import preset
from lgmd2jax._results.alarm_folder import save_alarm_fit
from lgmd2jax._results.fit_folder import MARKER
from lgmd2jax.alarms import AlarmRecipe, HeldOutScores, LabelledClip, evaluate, load_labels
from lgmd2jax.cli.recipe_results import folder_of, origin, starts_of
from lgmd2jax.fitting._search.descent import STOPPED

_ROBOT_T_SP = 0.65  # Table I's range is .65 on the robot to .78 off line


def run(options: argparse.Namespace, recipe: AlarmRecipe, start: float) -> None:
    """Make the fit, write its folder, and print the report."""
    folder = folder_of(options, recipe.name)
    check_folder(folder, MARKER)
    clips = recipe.file.load(_bar)
    if options.clips is not None:
        clips += _further(options.clips, recipe)
    digest = recipe.digest(clips)
    memory = starts_of(folder, digest, options.resume)
    alarms = sum(len(clip.windows) for clip in clips)
    print(f"fitting {', '.join(recipe.free.names)} to {len(clips)} clips with {alarms} alarms wanted", flush=True)
    if not any(clip.silent for clip in clips):
        print("no clip has a silence: nothing here speaks against a model that always fires", flush=True)
    fit = recipe.run(clips, progress=True, memory=memory)
    scores = None if fit.stopped or recipe.validation is None else _held_out_scores(recipe, fit.model)
    provenance = {"recipe": recipe.name, "seed": recipe.seed, "digest": digest}
    notes: dict[str, Any] = {"recipe": recipe.table, "digest": digest, "made": origin(start)}
    save_alarm_fit(fit, folder, name=recipe.name, held_out=scores, provenance=provenance, notes=notes)
    print(fit.summary(scores))
    print(f"\nwrote {folder}/ in {time.monotonic() - start:.0f} s; open {folder}/report.html")
    if fit.stopped:
        print(f"{STOPPED}: this is the best so far; go on with --resume")
        raise SystemExit(130)
    memory.forget()


def _further(path: Path, recipe: AlarmRecipe) -> tuple[LabelledClip, ...]:
    """The clips of another file; they may have a size of their own, but parameters belong to a rate and a scale."""
    file, eye = load_labels(path), recipe.file.eye
    for name in ("fps", "degrees_per_pixel"):
        value, expected = getattr(file.eye, name), getattr(eye, name)
        if value != expected:
            raise ValueError(f"{path} has {name} = {value}, the recipe's clips have {expected}; use one eye for both")
    return file.load(_bar)


def _held_out_scores(recipe: AlarmRecipe, model: LGMD2) -> HeldOutScores:
    """The fitted model and the paper's, at both ends of its T_sp and with its own N_ts, on clips that no fit saw."""
    clips = recipe.held_out()
    models = {"fitted": model}
    for T_sp in (float(preset("lgmd2").T_sp), _ROBOT_T_SP):
        models[f"Table I, T_sp {T_sp:g}"] = LGMD2(preset("lgmd2", T_sp=T_sp), eye=model.eye)
    return HeldOutScores.of({name: evaluate(candidate, clips) for name, candidate in models.items()})


def _bar(jobs: Iterable) -> Iterable:
    return tqdm(jobs, "clips", unit="source", leave=False, disable=None)
