"""`lgmd2jax watch LABELS`: what a model does on labelled clips."""

import argparse
import contextlib
import sys

from lgmd2jax._files.atomic import replaced
from lgmd2jax._handover.named import model_named, with_parameters
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._reports.section import as_text
from lgmd2jax.alarms import load_labels
from lgmd2jax.alarms._report import clip_section, write_table


def run(options: argparse.Namespace) -> None:
    """Judge the model, print the table, and write what was asked for."""
    from lgmd2jax._figures.alarms import clips_figure
    from lgmd2jax._figures.style import check_figure_path

    if options.figure:
        check_figure_path(options.figure)
    model = with_parameters(model_named(options.model), options.set)
    if not isinstance(model, LGMD2):
        raise ValueError(f"{options.model} is no LGMD2; its alarms are counted otherwise: see lgmd2jax respond")
    file = load_labels(options.labels)
    if model.eye is not None and model.eye.degrees_per_pixel != file.eye.degrees_per_pixel:
        print(
            f"lgmd2jax: warning: the model has degrees_per_pixel = {model.eye.degrees_per_pixel}, "
            f"{options.labels} {file.eye.degrees_per_pixel}: at another scale other parameters are right",
            file=sys.stderr,
        )
    outputs = [path for path in (options.csv, options.figure) if path]
    with contextlib.ExitStack() as stack:
        files = {path: stack.enter_context(replaced(path)) for path in outputs}
        evaluation = file.evaluate(model)
        if options.csv:
            write_table(files[options.csv], evaluation.verdicts())
        if options.figure:
            clips_figure(files[options.figure], evaluation, options.model)
    print(as_text([clip_section(evaluation, {})]))
    if outputs:
        print("wrote " + ", ".join(str(path) for path in outputs))
