"""`lgmd2jax fit RECIPE`: from target curves to a model that a robot runs."""

import argparse
import dataclasses
import time

import jax

from lgmd2jax._recipes.fit import Recipe
from lgmd2jax._recipes.load import load_recipe
from lgmd2jax._results.fit_folder import FitFolder
from lgmd2jax._results.posterior_nc import check_packages
from lgmd2jax._results.results_folder import SEARCH
from lgmd2jax.alarms import AlarmRecipe
from lgmd2jax.cli import fit_alarms
from lgmd2jax.cli.recipe_results import folder_of, kept_work, records, write_stopped
from lgmd2jax.fitting import Supplement
from lgmd2jax.fitting._search.descent import STOPPED

_DRAWS = "the draws of the posterior"


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
    _fit_curves(options, recipe, start)


def _fit_curves(options: argparse.Namespace, recipe: Recipe, start: float) -> None:
    """Make the fit, write its folder, add what else the recipe asks for, and print the report."""
    if recipe.samples:
        check_packages()
    folder, digest = folder_of(options, recipe.name), recipe.digest()
    with kept_work(folder, digest, options.resume) as memory:
        print(f"fitting {', '.join(recipe.free.names)} to {len(recipe.pairs)} conditions of {recipe.name}", flush=True)
        fit = recipe.run(progress=True, memory=memory)
        notes, provenance = records(recipe, digest, start)
        results = FitFolder(fit, folder, recipe.name, notes)
        further = recipe.further(fit, memory, progress=True)
        left = [*further, *([_DRAWS] if recipe.samples else [])]
        if fit.result == STOPPED:
            extra = Supplement(truth=recipe.truth, unfinished=(SEARCH, *left))
            write_stopped(folder, lambda: results.begin(extra, provenance | {"unfinished": SEARCH}), fit.summary(extra))
        extra = Supplement(truth=recipe.truth, unfinished=tuple(left))
        results.begin(extra, provenance)
        results.draw(extra)
        for words, add_to in further.items():
            left.remove(words)
            extra = dataclasses.replace(add_to(extra), unfinished=tuple(left))
            results.add(extra)
        if recipe.samples:
            draws = fit.sample(jax.random.key(recipe.seed), recipe.samples, memory=memory)
            extra = dataclasses.replace(extra, unfinished=())
            results.add_draws(extra, draws)
    print(fit.summary(extra))
    print(f"\nwrote {folder}/ in {time.monotonic() - start:.0f} s; open {folder}/report.html")
