"""`lgmd2jax calibrate RECIPE`: the probability of contact for a model that was fitted to labelled clips."""

import argparse
import math

from lgmd2jax._files.atomic import read_json
from lgmd2jax._files.lock import locked
from lgmd2jax._handover.model_file import load
from lgmd2jax._results.results_folder import ALARM_FIT, MARKER
from lgmd2jax._results.urgency import URGENCY_FILES, add_urgency
from lgmd2jax.alarms import load_recipe
from lgmd2jax.cli.recipe_results import check_eyes, clips_bar, folder_of

_WITHIN_MS = 500.0


def run(options: argparse.Namespace) -> None:
    """Calibrate on the recipe's clips, judge on its validation clips, add what came out to the folder."""
    given = options.within_ms
    if given is not None and not (math.isfinite(given) and given > 0):
        raise ValueError(f"--within-ms is {given:g}; give a positive number of ms")
    recipe = load_recipe(options.recipe)
    folder = folder_of(options, recipe.name)
    if not ((folder / MARKER).is_file() and (folder / "model.json").is_file()):
        raise ValueError(f"{folder} holds no fit (there is no {MARKER}); make it first: lgmd2jax fit {options.recipe}")
    if read_json(folder / MARKER).get("format") != ALARM_FIT:
        raise ValueError(f"{folder} holds a fit to curves; give the folder of one to labelled clips by -o")
    if (eye := load(folder / "model.json").eye) is not None:
        cure = "give the recipe by which it was fitted"
        check_eyes(eye, f"the model in {folder}", recipe.file.eye, f"the recipe {options.recipe}", cure)
    if recipe.validation is None:
        raise ValueError(f"{options.recipe} has no [validation], whose clips show whether the urgency holds; add it")
    within_ms = given or recipe.within_ms or _WITHIN_MS
    if within_ms < (frame_ms := 1000 / recipe.file.eye.fps):
        raise ValueError(f"within {within_ms:g} ms is less than a frame, {frame_ms:.3g} ms; was it meant in s?")
    with locked(folder):
        said = add_urgency(folder, recipe.file.load(clips_bar), recipe.held_out(), within_ms)
    print(said)
    print(f"wrote {folder}/model.json, {', '.join(URGENCY_FILES)}")
