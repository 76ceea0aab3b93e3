"""The arguments of `lgmd2jax characterise MODEL ...`."""

import argparse

from lgmd2jax.cli.options.model_option import MODEL_HELP
from lgmd2jax.cli.options.output import new_file

_EXAMPLES = """\
examples:
  lgmd2jax characterise lgmd2                              the shipped fit lgmd2
  lgmd2jax characterise preset:lgmd2 lgmd2 preset:balanced --figure models.png --json models.json
                                                           the paper's, a fitted one, and one like an LGMD1
  lgmd2jax characterise preset:lgmd2 preset:yue_rind       beside the LGMD1 that the paper compares with
  lgmd2jax characterise mine/model.json --ablate           without FFI, SFA, lateral inhibition, a pathway, ...
  lgmd2jax characterise lgmd2 --ablate size shunt          without these, one at a time
  lgmd2jax characterise mine/model.json --raster           objects moved by half a pixel; an eye of 1 degree a pixel
  lgmd2jax characterise lgmd2 --raster --seeds 5           and in five other draws of noise and texture

A model is shown the stimuli with its own eye and frame rate. A preset has neither: it is given the eye `locust`,
48 x 64 at 2 degrees and 100 fps, and its values per frame are scaled from 30 fps. The first model of an eye takes a
minute to compile and to render for, others a second.
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "characterise",
        help="measure 22 response properties of a looming-sensitive neuron on models",
        description="Measure the 22 response properties of a looming-sensitive neuron on models, side by side,\n"
        "each with its bound and the evidence for it.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("models", metavar="MODEL", nargs="+", help=MODEL_HELP)
    parser.add_argument("--json", type=new_file, metavar="FILE", help="also write values, bounds, verdicts, evidence")
    parser.add_argument("--figure", type=new_file, metavar="FILE", help="also draw small panels, one colour a model")
    parser.add_argument(
        "--intervals",
        action="store_true",
        help="intervals of the summary, from 100 models drawn from the covariance of the fit beside a model.json",
    )
    variants = parser.add_mutually_exclusive_group()
    variants.add_argument(
        "--ablate",
        metavar="MECHANISM",
        nargs="*",
        help="one model as it is, and without each of these: ffi, sfa, lateral, on, off, and of size, shunt, lag, "
        "membrane, rate, lamina, habituation those that it has; all of them where none is named",
    )
    variants.add_argument("--raster", action="store_true", help="one model on other rasters, and what changes by that")
    parser.add_argument(
        "--seeds", type=int, metavar="N", help="with --raster: in N other draws of noise and texture too"
    )
