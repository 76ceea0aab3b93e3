"""`lgmd2jax characterise MODEL ...`: the response properties of models, side by side."""

import argparse
import dataclasses

import jax

from lgmd2jax._characterise import Characterisation, ablations, characterise, differences, rasters
from lgmd2jax._characterise.result import table
from lgmd2jax._eye import Eye
from lgmd2jax._files.atomic import all_replaced, write_json
from lgmd2jax._handover.named import model_file, model_named
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.variants import at_frame_rate
from lgmd2jax._results.fit_folder import MARKER, load_fit
from lgmd2jax._words import Remark, warn
from lgmd2jax.fitting import Fit

_PRESET_FPS = 30.0  # the robot's camera, for which Table I is taken to hold


def run(options: argparse.Namespace) -> None:
    """Examine the models, write what was asked for, and print the table."""
    from lgmd2jax._figures.characterise import characterisation_figure
    from lgmd2jax._figures.style import check_figure_path

    ablates = options.ablate is not None
    if len(options.models) > 1 and (ablates or options.raster):
        option = "--ablate" if ablates else "--raster"
        raise ValueError(f"{option} takes one model; give the others by themselves")
    if options.seeds is not None and not options.raster:
        raise ValueError("--seeds draws other noise for --raster; add --raster")
    if len(set(options.models)) < len(options.models):
        raise ValueError("a model is named twice; name each once")
    if options.figure:
        check_figure_path(options.figure)
    models = {name: _named(name, options.intervals) for name in options.models}
    outputs = [path for path in (options.json, options.figure) if path is not None]
    with all_replaced(outputs, options.models) as files:
        results, remarks = _examined(models, options)
        if options.json:
            content = {"models": {name: result.plain() for name, result in results.items()}, "remarks": remarks}
            write_json(files[options.json], content)
        if options.figure:
            characterisation_figure(files[options.figure], results)
    print("\n".join([table(results), *(["", *remarks] if remarks else [])]))
    if outputs:
        print("\nwrote " + ", ".join(str(path) for path in outputs))


def _examined(models: dict[str, AbstractNetwork | Fit], options) -> tuple[dict[str, Characterisation], list[str]]:
    """The result of each model or variant by name, and remarks on their differences."""
    first = next(iter(models.values()))
    first = first.model if isinstance(first, Fit) else first
    if options.ablate is not None:
        return ablations(first, *options.ablate, progress=True), []
    if options.raster:
        results = rasters(first, seeds=options.seeds or 0, progress=True)
        return results, differences(results)
    results = {}
    for name, model in models.items():
        key = jax.random.key(0) if isinstance(model, Fit) else None
        results[name] = characterise(model, key=key, progress=True)
    return results, []


def _named(name: str, with_fit: bool) -> AbstractNetwork | Fit:
    """The model, or the fit that lies beside it; a preset on the eye of a locust."""
    path = model_file(name)
    if path is None:
        eye = Eye.preset("locust")
        model = dataclasses.replace(model_named(name), eye=dataclasses.replace(eye, fps=_PRESET_FPS))
        return _without_intervals(name, at_frame_rate(model, eye.fps), with_fit)
    if with_fit and path.name == "model.json" and path.with_name(MARKER).is_file():
        return load_fit(path.parent)
    return _without_intervals(name, model_named(name), with_fit)


def _without_intervals(name: str, model: AbstractNetwork, wanted: bool) -> AbstractNetwork:
    if wanted:
        warn(f"{name} has no intervals: no fit to curves lies beside it, with a covariance to draw from", Remark)
    return model
