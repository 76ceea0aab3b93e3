"""`lgmd2jax fit RECIPE`: from target curves to a model that a robot runs."""

import argparse
import time
from pathlib import Path

import jax

from lgmd2jax._files.folder import check_folder
from lgmd2jax._recipes.fit import Recipe
from lgmd2jax._recipes.load import load_recipe
from lgmd2jax._results.fit_folder import MARKER, save_fit
from lgmd2jax.alarms import AlarmRecipe
from lgmd2jax.cli import fit_alarms as _command_fit_alarms
from lgmd2jax.cli.recipe_option import add_recipe, folder_of, made_now, starts_of
from lgmd2jax.fitting import Fit
from lgmd2jax.fitting._descent import STOPPED
from lgmd2jax.fitting._law_fit import Beside, beside_law
from lgmd2jax.fitting._report import Extra

_EXAMPLES = """\
examples:
  lgmd2jax fit lgmd2                  the shipped recipe lgmd2: results in lgmd2/ here
  lgmd2jax fit mine.toml              one of your own: results in mine/ beside mine.toml
  lgmd2jax fit mine.toml -o tonight   results in tonight/
  lgmd2jax fit mine.toml --resume     go on where a fit was stopped or killed
  lgmd2jax fit video                  alarms on labelled clips instead of curves: in time, else silence
  lgmd2jax fit video --clips my.toml  recorded clips with their labels beside the rendered ones

Ctrl-C ends the search and writes the best so far. The folder then holds
  model.json        the fitted model with hard thresholds, to be handed over: see lgmd2jax/hard.py
  report.html       all of it on one page; report.txt as text
  fit.json          values, errors, intervals, every start, versions
  curves.csv        target, soft and hard model of every condition over time
  fit.png           the same as a picture
  diagnostics.png   starts, loss over steps, correlations, what the data determine
  posterior.nc      draws of the parameters, where the recipe asks for samples (arviz.from_netcdf)
"""


def add(commands) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "fit",
        help="fit a model to target curves",
        description="Fit the free parameters of a recipe to its target curves, and hand over the hard model.",
        epilog=_EXAMPLES,
    )
    add_recipe(parser)
    parser.add_argument("--resume", action="store_true", help="keep the starts that an earlier run has finished")
    parser.add_argument(
        "--clips",
        type=Path,
        metavar="FILE",
        help="for a recipe of kind 'alarms': labelled clips of your own beside its",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Make the fit of this kind of recipe."""
    began = time.monotonic()
    recipe = load_recipe(options.recipe)
    if isinstance(recipe, AlarmRecipe):
        _command_fit_alarms.run(options, recipe, began)
        return
    if not isinstance(recipe, Recipe):
        raise ValueError(f"{options.recipe} is the recipe of a sweep; run lgmd2jax sweep {options.recipe}")
    if options.clips is not None:
        raise ValueError(f"--clips is for a recipe of kind 'alarms'; that of {options.recipe} is 'fit'")
    _fit_curves(options, recipe, began)


def _fit_curves(options: argparse.Namespace, recipe: Recipe, began: float) -> None:
    """Make the fit, write its folder, and print the report."""
    folder = folder_of(options, recipe.name)
    check_folder(folder, MARKER)
    digest = recipe.digest()
    memory = starts_of(folder, digest, options.resume)
    print(f"fitting {', '.join(recipe.free.names)} to {len(recipe.pairs)} conditions of {recipe.name}", flush=True)
    fit = recipe.run(progress=True, memory=memory)
    stopped = fit.result == STOPPED
    extra = Extra(truth=recipe.truth) if stopped else _extra(recipe, fit)
    made = {
        "recipe": recipe.table,
        "digest": digest,
        "made": made_now(began),
    }
    provenance = {"recipe": recipe.name, "seed": recipe.seed, "digest": digest}
    draws = None if stopped or not recipe.samples else fit.sample(jax.random.key(recipe.seed), recipe.samples)
    save_fit(fit, folder, name=recipe.name, extra=extra, provenance=provenance, made=made, draws=draws)
    print(fit.summary(extra))
    print(f"\nwrote {folder}/ in {time.monotonic() - began:.0f} s; open {folder}/report.html")
    if stopped:
        print(f"{STOPPED}: this is the best so far; go on with --resume")
        raise SystemExit(130)
    memory.forget()


def _beside(recipe: Recipe, fit: Fit) -> Beside:
    return beside_law(recipe.pairs, fit.curves, smoothing=float(fit.observation.smoothing))


def _extra(recipe: Recipe, fit: Fit) -> Extra:
    """What the recipe asks for beside the fit."""
    return Extra(
        profiles={name: fit.profile(name) for name in recipe.profile},
        left_out=recipe.predict_each(progress=True) if recipe.leave_one_out else {},
        beside=_beside(recipe, fit) if recipe.looming_law else None,
        truth=recipe.truth,
    )
