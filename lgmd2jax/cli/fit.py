"""`lgmd2jax fit RECIPE`: from target curves to a model that a robot runs."""

import argparse
import time

import jax

from lgmd2jax._files.folder import check_folder
from lgmd2jax._recipes.fit import Recipe
from lgmd2jax._recipes.load import load_recipe
from lgmd2jax._results.fit_folder import MARKER, save_fit
from lgmd2jax.alarms import AlarmRecipe
from lgmd2jax.cli import fit_alarms
from lgmd2jax.cli.recipe_results import folder_of, origin, starts_of
from lgmd2jax.fitting import Fit, LawComparison, Supplement
from lgmd2jax.fitting._law_fit import compare_with_law
from lgmd2jax.fitting._search.descent import STOPPED


def run(options: argparse.Namespace) -> None:
    """Make the fit of this kind of recipe."""
    start = time.monotonic()
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
    """Make the fit, write its folder, and print the report."""
    folder = folder_of(options, recipe.name)
    check_folder(folder, MARKER)
    digest = recipe.digest()
    memory = starts_of(folder, digest, options.resume)
    print(f"fitting {', '.join(recipe.free.names)} to {len(recipe.pairs)} conditions of {recipe.name}", flush=True)
    fit = recipe.run(progress=True, memory=memory)
    stopped = fit.result == STOPPED
    extra = Supplement(truth=recipe.truth) if stopped else _extra(recipe, fit)
    notes = {"recipe": recipe.table, "digest": digest, "made": origin(start)}
    provenance = {"recipe": recipe.name, "seed": recipe.seed, "digest": digest}
    draws = None if stopped or not recipe.samples else fit.sample(jax.random.key(recipe.seed), recipe.samples)
    save_fit(fit, folder, name=recipe.name, extra=extra, provenance=provenance, notes=notes, draws=draws)
    print(fit.summary(extra))
    print(f"\nwrote {folder}/ in {time.monotonic() - start:.0f} s; open {folder}/report.html")
    if stopped:
        print(f"{STOPPED}: this is the best so far; go on with --resume")
        raise SystemExit(130)
    memory.forget()


def _beside(recipe: Recipe, fit: Fit) -> LawComparison:
    return compare_with_law(recipe.pairs, fit.curves, smoothing=float(fit.observation.smoothing))


def _extra(recipe: Recipe, fit: Fit) -> Supplement:
    """What the recipe asks for beside the fit."""
    return Supplement(
        profiles={name: fit.profile(name) for name in recipe.profile},
        left_out=recipe.predict_each(progress=True) if recipe.leave_one_out else {},
        looming_law=_beside(recipe, fit) if recipe.looming_law else None,
        truth=recipe.truth,
    )
