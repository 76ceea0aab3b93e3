"""`lgmd2jax watch LABELS`: what a model does on labelled clips."""

import argparse

from lgmd2jax._files.atomic import all_replaced, write_json
from lgmd2jax._handover.named import model_named, with_parameters
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._reports.section import as_text
from lgmd2jax._results.fit_json import plain
from lgmd2jax._video.field import other_field
from lgmd2jax.alarms import Comparison, Detector, detectors, evaluate, load_labels
from lgmd2jax.alarms._baselines import check_packages
from lgmd2jax.alarms._detectors import MODEL
from lgmd2jax.alarms._report import clip_section, comparison_section, write_table
from lgmd2jax.cli.warning import warn


def run(options: argparse.Namespace) -> None:
    """Judge the model, print the table, and write what was asked for."""
    from lgmd2jax._figures.alarms import clips_figure, comparison_figure
    from lgmd2jax._figures.style import check_figure_path

    if options.figure:
        check_figure_path(options.figure)
    if options.baselines:
        check_packages()
    model = with_parameters(model_named(options.model), options.set)
    if not isinstance(model, LGMD2):
        raise ValueError(f"{options.model} is not an LGMD2; for another network use lgmd2jax respond")
    file = load_labels(options.labels)
    if model.eye is not None and model.eye.degrees_per_pixel != file.eye.degrees_per_pixel:
        warn(
            f"the model has degrees_per_pixel = {model.eye.degrees_per_pixel}, but {options.labels} has "
            f"{file.eye.degrees_per_pixel}; parameters belong to one scale"
        )
    if model.eye is not None and other_field((file.eye.rows, file.eye.cols), model.eye):
        warn(
            f"the model's eye has {model.eye.rows} x {model.eye.cols} pixels, but that of {options.labels} has "
            f"{file.eye.rows} x {file.eye.cols}; an object fills another share of such a field"
        )
    outputs = [path for path in (options.csv, options.figure, options.json) if path]
    with all_replaced(outputs, (options.labels, options.model)) as files:
        if options.baselines:
            clips = file.load()
            evaluations = {MODEL: evaluate(model, clips), **detectors(clips, model)}
        else:
            evaluations = {MODEL: file.evaluate(model)}
        evaluation, comparison = evaluations[MODEL], None
        if options.baselines or options.json:
            comparison = Comparison.of({name: Detector(each) for name, each in evaluations.items()})
        if options.csv:
            write_table(files[options.csv], evaluation)
        if options.json and comparison is not None:
            content = {"model": options.model, "labels": options.labels, **plain(comparison.content())}
            write_json(files[options.json], content)
        if options.figure and options.baselines and comparison is not None:
            comparison_figure(files[options.figure], comparison)
        elif options.figure:
            clips_figure(files[options.figure], evaluation, options.model)
    print(as_text([clip_section(evaluation, {})]))
    if options.baselines and comparison is not None:
        print("\n" + as_text([comparison_section("Detectors side by side", comparison)]))
    if outputs:
        print("wrote " + ", ".join(str(path) for path in outputs))
