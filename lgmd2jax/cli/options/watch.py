"""The arguments of `lgmd2jax watch LABELS`."""

import argparse

from lgmd2jax.cli.options.model_option import add_model
from lgmd2jax.cli.options.output import new_file

_EXAMPLES = """\
examples:
  lgmd2jax watch mine.toml --model video              the shipped model that was fitted to rendered clips
  lgmd2jax watch mine.toml --set T_sp=.65             the paper's parameters, with another spike threshold
  lgmd2jax watch video --model mine/model.json        a model of your own on the shipped file of rendered clips
  lgmd2jax watch mine.toml --csv a.csv --figure a.png a row, and a line of the figure, for each clip
  lgmd2jax watch mine.toml --baselines --json a.json --figure a.png
                                                      beside Table I, a threshold on the frame difference, and one on
                                                      the divergence of optical flow (pip install 'lgmd2jax[baselines]')

A file of labelled clips says in which frames an alarm must be raised and in which none may be:
  [eye]                       # what the clips are resized to
  rows = 20
  cols = 36
  degrees_per_pixel = 1.95
  fps = 30
  [[clip]]
  file = "crash.mp4"
  alarm = [[149, 175]]        # frames in which an alarm must be raised; without it the whole clip must be silent
  source = "dashcam of May"   # clips of one source are left out together; by default each is a source of its own
`lgmd2jax fit video --clips mine.toml` fits a model to it. Clips are decoded once and kept in your cache.

Detectors differ in how often they alarm, so --baselines compares them at equal budgets: 1, 2 and 4 false alarms a
minute. Each detector, the model too, has the lowest threshold that keeps within the budget on the other sources; so no
source has a say in the threshold by which it is evaluated. The model's and Table I's own thresholds are shown besides.
The interval of how many more windows the model hits is that of a paired bootstrap over sources. With a single source
its own clips choose, and the report says so.

The JSON file has detectors.NAME.hits (count, windows, value, low, high) and .false_alarms_per_minute (count, minutes,
value, low, high), the same for each budget under .budgets.1, .2 and .4, and a list of the clips.
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "watch",
        help="evaluate a model's alarms on labelled clips",
        description="Run a model over labelled clips: hits, false alarms a minute, time before contact.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("labels", metavar="LABELS", help="a TOML file of labelled clips, or the name of a shipped one")
    add_model(parser)
    parser.add_argument("--csv", type=new_file, metavar="FILE", help="also write a row for each clip")
    parser.add_argument(
        "--figure",
        type=new_file,
        metavar="FILE",
        help="also draw a line for each clip; with --baselines, hits against false alarms a minute of all detectors",
    )
    parser.add_argument("--json", type=new_file, metavar="FILE", help="also write all scores with their intervals")
    parser.add_argument(
        "--baselines",
        action="store_true",
        help="compare with Table I and with plain detectors; clips are held in memory then",
    )
