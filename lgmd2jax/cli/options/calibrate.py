"""The arguments of `lgmd2jax calibrate RECIPE`."""

import argparse

from lgmd2jax.cli.options.recipe_option import add_recipe

_EXAMPLES = """\
examples:
  lgmd2jax calibrate fits/video.toml                  the fit in fits/video/ gets a probability of contact
  lgmd2jax calibrate mine.toml -o tonight             that in tonight/, on the clips of the recipe mine.toml
  lgmd2jax calibrate mine.toml --within-ms 800        contact within 800 ms, instead of the recipe's time or 500

The folder holds the results of `lgmd2jax fit` by a recipe of kind "alarms". The probability of contact is a logistic
function of the adapted potential, of the potential's average and its rise, and of the inhibition, fitted to the
recipe's clips and judged on its [validation] clips. It goes into model.json, by which hard.py and `lgmd2jax live` tell
it with every frame; reliability.png shows whether it comes true, urgency.json holds the numbers. A recipe with
  [urgency]
  within_ms = 500
has it from the fit on. It holds where contact is as frequent as in the clips.
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "calibrate",
        help="add the probability of contact to a fit of alarms",
        description="Add to a fitted model the probability of contact within a time, calibrated on labelled clips.",
        epilog=_EXAMPLES,
    )
    add_recipe(parser)
    parser.add_argument(
        "--within-ms",
        type=float,
        metavar="MS",
        help="within which time contact follows (default: the recipe's, or 500)",
    )
