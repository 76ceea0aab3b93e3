"""The arguments of `lgmd2jax export MODEL --python DIR`."""

import argparse
from pathlib import Path

from lgmd2jax.cli.options.model_option import MODEL_HELP

_EXAMPLES = """\
examples:
  lgmd2jax export dcmd --python robot           the shipped fit dcmd: writes robot/model.json and robot/hard.py
  lgmd2jax export mine/model.json --python .    one of your own, into the current folder
  lgmd2jax export preset:lgmd2 --python robot   the paper's parameters

The folder needs Python and NumPy, and nothing of lgmd2jax. Whoever loads model.json runs the test clip in it first, and
refuses the file where the response is not the one that it states.
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "export",
        help="hand a model over to a robot",
        description="Write a model with hard thresholds, and the one file of NumPy that runs it, into a folder.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("model", metavar="MODEL", help=MODEL_HELP)
    parser.add_argument(
        "--python",
        type=Path,
        required=True,
        metavar="DIR",
        help="the folder for model.json and hard.py; created if missing",
    )
