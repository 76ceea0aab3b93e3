"""The arguments of `lgmd2jax sweep RECIPE`."""

import argparse

from lgmd2jax.cli.options.recipe_option import add_recipe

_EXAMPLES = """\
examples:
  lgmd2jax sweep contrast_speed             a shipped recipe: results in contrast_speed/ here
  lgmd2jax sweep mine.toml                  one of your own: results in mine/ beside mine.toml
  lgmd2jax sweep mine.toml -o tonight       results in tonight/

A sweep that was stopped or killed goes on where it was when the same line is given again. The folder holds
  sweep.zarr   the labelled arrays: xarray.open_zarr("mine/sweep.zarr", consolidated=False)
  sweep.png    the surface that the recipe asks for

A recipe is a TOML file:
  kind = "sweep"
  family = "looming"
  [eye]
  preset = "locust"
  [stimulus]
  contrast = { from = -0.05, to = -1, count = 20 }
  l_over_v = [10, 20, 40, 80]
  [figure]
  value = "peak"
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "sweep",
        help="map the response over stimuli and parameters",
        description="Compute the response over a grid of stimuli, parameters and models, and draw it as a surface.",
        epilog=_EXAMPLES,
    )
    add_recipe(parser)
