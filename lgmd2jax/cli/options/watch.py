"""The arguments of `lgmd2jax watch LABELS`."""

import argparse
from pathlib import Path

from lgmd2jax.cli.options.model_option import add_model

_EXAMPLES = """\
examples:
  lgmd2jax watch mine.toml --model video              the shipped model that was fitted to rendered clips
  lgmd2jax watch mine.toml --set T_sp=.65             the paper's parameters, with another spike threshold
  lgmd2jax watch video --model mine/model.json        a model of your own on the shipped file of rendered clips
  lgmd2jax watch mine.toml --csv a.csv --figure a.png a row, and a line of the figure, for each clip

A file of labelled clips says in which frames an alarm must be raised and in which none may be:
  [eye]                       # what the clips are resized to
  rows = 20
  cols = 36
  degrees_per_pixel = 1.95
  fps = 30
  [[clip]]
  file = "crash.mp4"
  alarm = [[149, 175]]        # frames in which an alarm must be raised; without it the whole clip must be silent
`lgmd2jax fit video --clips mine.toml` fits a model to it. Clips are decoded once and kept in your cache.
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "watch",
        help="judge a model's alarms on labelled clips",
        description="Run a model over labelled clips: hits, false alarms a minute, time before contact.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("labels", metavar="LABELS", help="a TOML file of labelled clips, or the name of a shipped one")
    add_model(parser)
    parser.add_argument("--csv", type=Path, metavar="FILE", help="also write a row for each clip")
    parser.add_argument("--figure", type=Path, metavar="FILE", help="also draw a line for each clip")
