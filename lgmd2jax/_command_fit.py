"""`lgmd2jax fit RECIPE`: from target curves to a model that a robot runs."""

import argparse
import datetime
import platform
import time

import jax

from lgmd2jax._folder import check_folder
from lgmd2jax._memory import FileMemory
from lgmd2jax._recipe import Recipe, load_recipe
from lgmd2jax._recipe_argument import add_recipe, folder_of
from lgmd2jax._results import MARKER, save_fit
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
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Make the fit, write its folder, and print the report."""
    began = time.monotonic()
    recipe = load_recipe(options.recipe)
    folder = folder_of(options, recipe.name)
    check_folder(folder, MARKER)
    digest = recipe.digest()
    memory = FileMemory(folder.absolute().with_name(f".{folder.absolute().name}.starts.jsonl"), digest, options.resume)
    print(f"fitting {', '.join(recipe.free.names)} to {len(recipe.pairs)} conditions of {recipe.name}", flush=True)
    fit = recipe.run(progress=True, memory=memory)
    stopped = fit.result == STOPPED
    extra = Extra(truth=recipe.truth) if stopped else _extra(recipe, fit)
    made = {
        "recipe": recipe.table,
        "digest": digest,
        "made": {
            "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
            "seconds": round(time.monotonic() - began, 1),
            "python": platform.python_version(),
            "machine": f"{platform.system()} {platform.machine()}",
        },
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
