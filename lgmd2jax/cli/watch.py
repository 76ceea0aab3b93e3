"""`lgmd2jax watch LABELS`: what a model does on labelled clips."""

import argparse
import contextlib
import sys
from pathlib import Path

from lgmd2jax._files.atomic import replaced
from lgmd2jax._handover.named import add_model, model_named, with_parameters
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax.alarms import load_footage, watch
from lgmd2jax.alarms._report import watched, write_table

_EXAMPLES = """\
examples:
  lgmd2jax watch mine.toml --model video              the shipped model that was fitted to rendered clips
  lgmd2jax watch mine.toml --set T_sp=.65             Table I's, with a threshold of your own
  lgmd2jax watch video --model mine/model.json        a model of your own on the shipped file of rendered clips
  lgmd2jax watch mine.toml --csv a.csv --figure a.png a row, and a line, for each clip

A file of labelled clips says in which frames an alarm must be raised and in which none may be; `lgmd2jax fit video
--clips mine.toml` fits to it. Clips are decoded once and kept in your cache.
"""


def add(commands) -> None:
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
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Judge the model, print the table, and write what was asked for."""
    from lgmd2jax._figures.alarms import clips_figure
    from lgmd2jax._figures.style import check_figure_path

    if options.figure:
        check_figure_path(options.figure)
    model = with_parameters(model_named(options.model), options.set)
    if not isinstance(model, LGMD2):
        raise ValueError(f"{options.model} is no LGMD2; its alarms are counted otherwise: see lgmd2jax respond")
    file = load_footage(options.labels)
    if model.eye is not None and model.eye.degrees_per_pixel != file.eye.degrees_per_pixel:
        print(
            f"lgmd2jax: warning: the model has degrees_per_pixel = {model.eye.degrees_per_pixel}, "
            f"{options.labels} {file.eye.degrees_per_pixel}: at another scale other parameters are right",
            file=sys.stderr,
        )
    outputs = [path for path in (options.csv, options.figure) if path]
    with contextlib.ExitStack() as stack:
        files = {path: stack.enter_context(replaced(path)) for path in outputs}
        seen = watch(model, file.load())
        if options.csv:
            write_table(files[options.csv], seen.verdicts())
        if options.figure:
            clips_figure(files[options.figure], seen, options.model)
    print(watched(seen))
    if outputs:
        print("wrote " + ", ".join(str(path) for path in outputs))
