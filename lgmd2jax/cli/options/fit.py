"""The arguments of `lgmd2jax fit RECIPE`."""

import argparse
from pathlib import Path

from lgmd2jax.cli.options.recipe_option import add_recipe

_EXAMPLES = """\
examples:
  lgmd2jax fit lgmd2                  the shipped recipe lgmd2: results in lgmd2/ here
  lgmd2jax fit mine.toml              one of your own: results in mine/ beside mine.toml
  lgmd2jax fit mine.toml -o tonight   results in tonight/
  lgmd2jax fit mine.toml --resume     go on where a fit was stopped or killed
  lgmd2jax fit mine.toml --mechanisms size shunt -o with-both
                                      the recipe's fit of a circuit with these mechanisms
  lgmd2jax fit video                  alarms on labelled clips instead of curves: before a contact, else silence
  lgmd2jax fit video --clips my.toml  the same with labelled clips of your own beside the rendered ones; each source
                                      of yours is also evaluated by a shorter search without it, beside plain detectors
  lgmd2jax fit video --clips my.toml --clips-weight 3
                                      yours together weigh three times what the rendered ones do
  lgmd2jax fit video --clips my.toml --clips-only
                                      yours alone

A recipe is a TOML file:
  protocol = "mine-stimuli.toml"      # stimuli (see lgmd2jax stimuli --help) with their target curves
  preset = "lgmd2"
  [free]                              # what is not named stays as the preset has it
  k = {}                              # between the default bounds
  tau3 = { low = 100, high = 1000 }

The fit is written before profiles, leave-one-out and draws, which are added one by one; fit.json and the report say
what is still to come. Ctrl-C ends the search and writes the best so far, but not over finished results. The folder
then holds
  model.json        the fitted model with hard thresholds, for lgmd2jax export and --model
  report.html       all results on one page; report.txt as text
  fit.json          values, errors, intervals, every start, versions
  curves.csv        target, soft and hard model of every condition over time
  fit.png           the same as a picture
  diagnostics.png   starts, loss over steps, correlations, what the data determine
  posterior.nc      draws of the parameters, where the recipe asks for samples (arviz.from_netcdf)
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "fit",
        help="fit a model to target curves, or to labelled clips",
        description="Fit the free parameters of a recipe to its target curves or labelled clips,\n"
        "and hand over the model with hard thresholds.",
        epilog=_EXAMPLES,
    )
    add_recipe(parser)
    parser.add_argument(
        "--resume",
        action="store_true",
        help="go on where an earlier run was stopped or killed",
    )
    parser.add_argument(
        "--mechanisms",
        nargs="*",
        metavar="NAME",
        help="the mechanisms of the circuit instead of the recipe's: of size, shunt, lag, membrane, rate, "
        "lamina, habituation; none for the paper's circuit. Parameters that come into play by that are free too",
    )
    parser.add_argument(
        "--clips",
        type=Path,
        metavar="FILE",
        help="for a recipe of kind 'alarms': labelled clips of your own beside the recipe's, see lgmd2jax watch --help",
    )
    parser.add_argument(
        "--clips-weight",
        type=float,
        metavar="N",
        help="what recorded clips weigh together, as a multiple of the rendered ones together (default: the recipe's "
        "weights.recorded, else 1)",
    )
    parser.add_argument("--clips-only", action="store_true", help="fit to the clips of --clips and to no others")
