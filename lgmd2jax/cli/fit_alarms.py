"""`lgmd2jax fit RECIPE` for a recipe of kind "alarms": from labelled clips to a model that a robot runs."""

import argparse
import time
from collections.abc import Iterable
from pathlib import Path

from tqdm import tqdm

from lgmd2jax._files.folder import check_folder
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.parameters import preset
from lgmd2jax._results.alarm_folder import AlarmFolder
from lgmd2jax._results.results_folder import MARKER, SEARCH
from lgmd2jax._results.urgency import add_urgency
from lgmd2jax.alarms import AlarmRecipe, HeldOutScores, LabelledClip, evaluate, load_labels
from lgmd2jax.cli.recipe_results import folder_of, kept_work, records, write_stopped

_HELD_OUT = "the scores on clips that the fit did not see"
_ROBOT_T_SP = 0.65  # Table I's range is .65 on the robot to .78 off line


def run(options: argparse.Namespace, recipe: AlarmRecipe, start: float) -> None:
    """Make the fit, write its folder, add its scores on held-out clips, and print the report."""
    folder = folder_of(options, recipe.name)
    check_folder(folder, MARKER)
    clips = recipe.file.load(_bar)
    if options.clips is not None:
        clips += _further(options.clips, recipe)
    digest = recipe.digest(clips)
    with kept_work(folder, digest, options.resume) as memory:
        alarms = sum(len(clip.windows) for clip in clips)
        print(f"fitting {', '.join(recipe.free.names)} to {len(clips)} clips with {alarms} alarms wanted", flush=True)
        if not any(clip.silent for clip in clips):
            print("no clip has a silence: nothing here speaks against a model that always fires", flush=True)
        fit, scores = recipe.run(clips, progress=True, memory=memory), None
        left = [] if recipe.validation is None else [_HELD_OUT]
        notes, provenance = records(recipe, digest, start)
        results = AlarmFolder(fit, folder, recipe.name, notes)
        if fit.stopped:
            provenance["unfinished"] = SEARCH
            write_stopped(folder, lambda: results.begin([SEARCH, *left], provenance), fit.summary())
        results.begin(left, provenance)
        results.draw(left)
        if recipe.validation is not None:
            scores = _held_out_scores(recipe, fit.model)
            results.add(scores)
        said = "" if recipe.within_ms is None else add_urgency(folder, clips, recipe.held_out(), recipe.within_ms)
    print(fit.summary(scores))
    print(said)
    print(f"\nwrote {folder}/ in {time.monotonic() - start:.0f} s; open {folder}/report.html")


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
