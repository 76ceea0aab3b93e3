"""The arguments of `lgmd2jax import FILE ... -o FOLDER`."""

import argparse
from pathlib import Path

from lgmd2jax.cli.options.trials_option import add_trials

# What a screen is taken to show where nobody tells.
SCREEN = {"fps": 60.0, "stop_angle": 80.0, "contrast": -0.9, "background": 200.0}
_EXAMPLES = """\
examples:
  lgmd2jax import recordings/ -o mine --fps 60 --stop-angle 80    trials.csv and spikes.csv of a session's clock
  lgmd2jax import a.nwb b.nwb -o mine --event collision_time      one file an animal
  lgmd2jax import trials.txt -o mine --time-unit s --l-over-v 40  a column a trial, one l/|v|

The folder holds
  trials.png      a raster and the rates of each condition
  trials.csv, spikes.csv   all trials, in ms from collision
  protocol.toml   the looms that were shown, with the spikes in targets/ as what a fit aims at
  fit.toml        the recipe of a fit, to be changed as you like
Then `lgmd2jax looming mine` tells alpha and delta, and `lgmd2jax fit mine/fit.toml` fits the model.
Sessions of noise, and animals that do not answer, are named and left out of the targets, as by lgmd2jax looming.
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "import",
        help="show what recordings hold, and make a protocol and a recipe of them",
        description="Read recorded trials, show what was found, and write a protocol with its targets, ready to fit.",
        epilog=_EXAMPLES,
    )
    add_trials(parser)
    parser.add_argument("-o", "--output", type=Path, metavar="FOLDER", required=True, help="the folder to write")
    parser.add_argument("--replace", action="store_true", help="replace an earlier import in this folder")
    parser.add_argument("--fps", type=float, metavar="HZ", help="frame rate of the screen (assumed: 60)")
    parser.add_argument("--stop-angle", type=float, metavar="DEG", help="full angle where the loom stops (assumed: 80)")
    parser.add_argument("--contrast", type=float, metavar="WEBER", help="Weber contrast of the object (assumed: -0.9)")
    parser.add_argument(
        "--background", type=float, metavar="LEVEL", help="grey level of the ground, 0 to 255 (assumed: 200)"
    )
    parser.add_argument(
        "--kernel-ms",
        type=float,
        default=20.0,
        metavar="MS",
        help="s.d. of the Gaussian that makes rates of spikes (default: 20)",
    )
