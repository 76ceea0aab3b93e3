"""`lgmd2jax characterise MODEL ...`: the response properties of models, side by side."""

import argparse
import contextlib
import dataclasses
import json
from pathlib import Path

import jax

from lgmd2jax._characterise import Characterisation, ablations, characterise, differences, rasters
from lgmd2jax._characterise.table import table
from lgmd2jax._eye import Eye
from lgmd2jax._files.atomic import replaced
from lgmd2jax._handover.named import model_file, model_named
from lgmd2jax._network.abstract import Network
from lgmd2jax._network.frame_rate import at_frame_rate
from lgmd2jax._results.fit_folder import MARKER, load_fit
from lgmd2jax.fitting import Fit

_PRESET_FPS = 30.0  # the robot's camera, for which Table I is taken to hold
_EXAMPLES = """\
examples:
  lgmd2jax characterise lgmd2                              the shipped fit lgmd2
  lgmd2jax characterise preset:lgmd2 lgmd2 preset:balanced --figure models.png --json models.json
                                                           the paper's, a fitted one, and one like an LGMD1
  lgmd2jax characterise preset:lgmd2 preset:yue_rind       beside the LGMD1 that the paper compares with
  lgmd2jax characterise mine/model.json --ablate           without FFI, SFA, lateral inhibition, ON pathway
  lgmd2jax characterise mine/model.json --raster           objects moved by half a pixel; an eye of 1 degree a pixel

A model is shown the stimuli with its own eye and frame rate. A preset has neither: it is given the eye `locust`,
48 x 64 at 2 degrees and 100 fps, and its values per frame are scaled from 30 fps. The first model of an eye takes a
minute to compile and to render for, others a second.
"""


def add(commands) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "characterise",
        help="22 response properties of a looming-sensitive neuron, measured on models",
        description="Measure the 22 response properties of a looming-sensitive neuron on models, side by side, each "
        "with its bound and the evidence for it.",
        epilog=_EXAMPLES,
    )
    parser.add_argument(
        "models",
        metavar="MODEL",
        nargs="+",
        help="a hand-over file model.json, the name of a shipped fit, or preset:NAME",
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="values, bounds, verdicts, evidence")
    parser.add_argument("--figure", type=Path, metavar="FILE", help="small panels, one colour a model")
    parser.add_argument(
        "--intervals",
        action="store_true",
        help="intervals of the summary, from 100 models drawn from the covariance of the fit beside a model.json",
    )
    variants = parser.add_mutually_exclusive_group()
    variants.add_argument("--ablate", action="store_true", help="one model as it is and with mechanisms taken out")
    variants.add_argument("--raster", action="store_true", help="one model on other rasters, and what changes by that")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Examine the models, write what was asked for, and print the table."""
    from lgmd2jax._figures.characterise import characterisation_figure
    from lgmd2jax._figures.style import check_figure_path

    if len(options.models) > 1 and (options.ablate or options.raster):
        option = "--ablate" if options.ablate else "--raster"
        raise ValueError(f"{option} takes one model; give the others by themselves")
    if len(set(options.models)) < len(options.models):
        raise ValueError("a model is named twice; name each once")
    if options.figure:
        check_figure_path(options.figure)
    models = {name: _named(name, options.intervals) for name in options.models}
    outputs = [path for path in (options.json, options.figure) if path is not None]
    with contextlib.ExitStack() as stack:
        files = {path: stack.enter_context(replaced(path)) for path in outputs}
        found, remarks = _examined(models, options)
        if options.json:
            content = {"models": {name: it.plain() for name, it in found.items()}, "remarks": remarks}
            files[options.json].write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        if options.figure:
            characterisation_figure(files[options.figure], found)
    print("\n".join([table(found), *(["", *remarks] if remarks else [])]))
    if outputs:
        print("\nwrote " + ", ".join(str(path) for path in outputs))


def _examined(models: dict[str, Network | Fit], options) -> tuple[dict[str, Characterisation], list[str]]:
    one = next(iter(models.values()))
    one = one.model if isinstance(one, Fit) else one
    if options.ablate:
        return ablations(one, progress=True), []
    if options.raster:
        found = rasters(one, progress=True)
        return found, differences(found)
    found = {}
    for name, model in models.items():
        key = jax.random.key(0) if isinstance(model, Fit) else None
        found[name] = characterise(model, key=key, progress=True)
    return found, []


def _named(name: str, with_fit: bool) -> Network | Fit:
    """The model, or the fit that lies beside it; a preset on the eye of a locust."""
    path = model_file(name)
    if path is None:
        eye = Eye.preset("locust")
        model = dataclasses.replace(model_named(name), eye=dataclasses.replace(eye, fps=_PRESET_FPS))
        return at_frame_rate(model, eye.fps)
    if with_fit and path.name == "model.json" and path.with_name(MARKER).is_file():
        return load_fit(path.parent)
    return model_named(name)
