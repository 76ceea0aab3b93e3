"""`lgmd2jax fit RECIPE`: from target curves to a model that a robot runs."""

import argparse
import dataclasses
import importlib
import re
import time
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import jax

from lgmd2jax._files.atomic import read_json, replaced
from lgmd2jax._files.lock import locked
from lgmd2jax._recipes.fit import Recipe
from lgmd2jax._recipes.load import load_recipe
from lgmd2jax._results.fit_folder import FitFolder, load_fit
from lgmd2jax._results.posterior_nc import check_packages
from lgmd2jax._results.results_folder import MARKER, SEARCH, is_finished
from lgmd2jax.alarms import AlarmRecipe
from lgmd2jax.cli import fit_alarms
from lgmd2jax.cli.recipe_results import folder_of, kept_work, records, write_stopped
from lgmd2jax.fitting import AnimalFits, Fit, Supplement
from lgmd2jax.fitting._search.descent import STOPPED

_DRAWS = "the draws of the posterior"
_OVER_ANIMALS = "animals.csv", "animals.png", "report.txt"  # beside the folders of fits to one animal each


def run(options: argparse.Namespace) -> None:
    """Make the fit of this kind of recipe."""
    start = time.monotonic()
    fit_alarms.check_options(options)
    recipe = load_recipe(options.recipe)
    if isinstance(recipe, AlarmRecipe):
        if options.mechanisms is not None:
            raise ValueError("--mechanisms is for a recipe of kind 'fit'; write those of alarms in its [structure]")
        fit_alarms.run(options, recipe, start)
        return
    if not isinstance(recipe, Recipe):
        raise ValueError(f"{options.recipe} is the recipe of a sweep; run lgmd2jax sweep {options.recipe}")
    if options.clips is not None:
        raise ValueError(f"--clips is for a recipe of kind 'alarms'; that of {options.recipe} is 'fit'")
    if options.mechanisms is not None:
        recipe = recipe.with_mechanisms(*options.mechanisms)
    folder = folder_of(options, recipe.name)
    if recipe.animals:
        with locked(folder):
            _fit_animals(options, recipe, folder, start)
        return
    fit, extra = _fit_curves(options, recipe, folder, start)
    print(fit.summary(extra))
    print(f"\nwrote {folder}/ in {time.monotonic() - start:.0f} s; open {folder}/report.html")


def _fit_animals(options: argparse.Namespace, recipe: Recipe, folder: Path, start: float) -> None:
    """Make one fit an animal, each in a folder of its own, and what holds over them."""
    folder.mkdir(exist_ok=True)
    fits, recipes = {}, recipe.each()
    for (animal, own), name in zip(recipes.items(), folder_names(recipes), strict=True):
        place = folder / name
        if options.resume and is_finished(place) and read_json(place / MARKER).get("digest") == own.digest():
            fits[animal] = load_fit(place)
        else:
            fits[animal], _ = _fit_curves(options, own, place, time.monotonic())
    animals = AnimalFits(fits)
    table, figure, report = (folder / name for name in _OVER_ANIMALS)
    for path, write in ((table, animals.write_csv), (figure, animals.plot)):
        with replaced(path) as temporary:
            write(temporary)
    with replaced(report) as temporary:
        temporary.write_text(animals.summary() + "\n", encoding="utf-8")
    print(animals.summary())
    print(f"\nwrote {folder}/ in {time.monotonic() - start:.0f} s: a folder an animal, animals.csv and animals.png")


def folder_names(animals: Iterable[str]) -> list[str]:
    """A name of a folder for each animal, of letters that all file systems take, no two alike."""
    taken: set[str] = {*_OVER_ANIMALS}
    names = []
    for animal in animals:
        name = re.sub(r"[^\w.-]", "_", animal).lstrip(".") or "_"
        while name.lower() in taken:
            name += "_"
        taken.add(name.lower())
        names.append(name)
    return names


def _fit_curves(options: argparse.Namespace, recipe: Recipe, folder: Path, start: float) -> tuple[Fit, Supplement]:
    """Make the fit, write its folder, and add what else the recipe asks for."""
    if recipe.samples:
        check_packages()
    digest = recipe.digest()
    # XLA leaves one core to the pool: it loads matplotlib beside the search, and draws beside what follows.
    with kept_work(folder, digest, options.resume) as memory, ThreadPoolExecutor(1) as pool:
        pool.submit(importlib.import_module, "lgmd2jax._figures.fit")
        print(f"fitting {', '.join(recipe.free.names)} to {len(recipe.pairs)} conditions of {recipe.name}", flush=True)
        fit = recipe.run(progress=True, memory=memory)
        notes, provenance = records(recipe, digest, start, folder)
        results = FitFolder(fit, folder, recipe.name, notes)
        further = recipe.further(fit, memory, progress=True)
        left = [*further, *([_DRAWS] if recipe.samples else [])]
        if fit.result == STOPPED:
            extra = Supplement(truth=recipe.truth, unfinished=(SEARCH, *left))
            write_stopped(folder, lambda: results.begin(extra, provenance | {"unfinished": SEARCH}), fit.summary(extra))
        extra = Supplement(truth=recipe.truth, unfinished=tuple(left))
        results.begin(extra, provenance)
        drawing = pool.submit(results.draw, extra)
        for words, add_to in further.items():
            left.remove(words)
            extra = dataclasses.replace(add_to(extra), unfinished=tuple(left))
            drawing.result()  # the folder is written by one at a time
            results.add(extra)
        drawing.result()
        if recipe.samples:
            draws = fit.sample(jax.random.key(recipe.seed), recipe.samples, memory=memory)
            extra = dataclasses.replace(extra, unfinished=())
            results.add_draws(extra, draws)
    return fit, extra
