"""`lgmd2jax fit RECIPE`: from recorded curves to a model that a robot runs."""

import argparse
from pathlib import Path

from lgmd2jax._catalogue import results_folder
from lgmd2jax._recipe import load_recipe, write_results

_EXAMPLES = """\
examples:
  lgmd2jax fit dcmd                   the shipped recipe dcmd: results in dcmd/ here
  lgmd2jax fit mine.toml              one of your own: results in mine/ beside mine.toml
  lgmd2jax fit mine.toml -o tonight   results in tonight/

The folder then holds
  model.json   the fitted model with hard thresholds, to be handed over: see lgmd2jax/hard.py
  curves.csv   target, soft and hard rate of every condition over time
  fit.json     free parameters with value and bounds, loss, variance explained, versions
  fit.png      the same as a picture
"""


def add(commands) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "fit",
        help="fit a model to recorded curves",
        description="Fit the free parameters of a recipe to its target curves, and hand over the hard model.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("recipe", metavar="RECIPE", help="a TOML file, or the name of a shipped recipe")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FOLDER", help="default: beside the recipe; for a shipped one, here"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Make the fit, write its folder, and say how good it is."""
    from lgmd2jax._figures_fit import fit_figure

    recipe = load_recipe(options.recipe)
    folder = options.output or results_folder(options.recipe) / recipe.name
    print(f"fitting {', '.join(recipe.free.bounds)} of {recipe.name}")
    result = recipe.run()
    curves = write_results(recipe, result, folder, fit_figure)
    for name, (low, high) in recipe.free.bounds.items():
        value = float(getattr(result.model.parameters, name))
        note = "  on its bound" if min(value - low, high - value) < 1e-3 * (high - low) else ""
        print(f"  {name:8} {value:10.4g}   within ({low:g}, {high:g}){note}")
    steps = " + ".join(str(steps) for steps in result.steps)
    print(f"  solver: {result.result} after {steps} steps")
    for curve in curves:
        print(f"  {curve.name}: R2 {curve.r2['hard']:.3f} of the hard model, {curve.r2['soft']:.3f} of the soft one")
    print(f"wrote {folder}/: model.json, curves.csv, fit.json, fit.png")
