"""The arguments of `lgmd2jax export MODEL --python DIR | --c DIR | --ros DIR`."""

import argparse
from pathlib import Path

from lgmd2jax.cli.options.model_option import MODEL_HELP

_EXAMPLES = """\
examples:
  lgmd2jax export dcmd --python robot           the shipped fit dcmd: writes robot/model.json and robot/hard.py
  lgmd2jax export mine/model.json --python .    one of your own, into the current folder
  lgmd2jax export preset:lgmd2 --python robot   the paper's parameters
  lgmd2jax export lgmd2 --c firmware --rows 72 --cols 99 --degrees-per-pixel .7 --fps 30
                                                C99 for a camera of this size, field and rate
  lgmd2jax export lgmd2 --c firmware --ram 196608
                                                C99 for the model's own eye, if it fits into 192 KB
  lgmd2jax export video --c firmware --protocol robot --clip crash.mp4
                                                and the gap to the hard model on these stimuli and a clip
  lgmd2jax export video --ros lgmd2             a ROS 2 package: images in, alarm and urgency out

With --python the folder needs Python and NumPy, and nothing of lgmd2jax. Whoever loads model.json runs the test clip in
it first, and refuses the file where the response is not the one that it states.

With --c the folder holds lgmd2.h and lgmd2.c, which use no heap; there, `make test` runs the same test clip, and
stm32f407/ is an example for a microcontroller. The urgency goes with it where the eye is the model's own. What is
compared with a mean over the field (k, and T_ffi or A_ffi) goes as 1/(field area), and what is compared with a change
in a frame goes with the time that a frame lasts. Then soft model and C are compared with the hard model on the stimuli
of a protocol, rendered for that eye, and on clips.
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "export",
        help="hand a model over to a robot",
        description="Write a model with hard thresholds, and what runs it, into a folder: NumPy, C99 or ROS 2.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("model", metavar="MODEL", help=MODEL_HELP)
    language = parser.add_mutually_exclusive_group(required=True)
    language.add_argument(
        "--python", type=Path, metavar="DIR", help="the folder for model.json and hard.py; created if missing"
    )
    language.add_argument(
        "--c", type=Path, metavar="DIR", help="the folder for model.json and the C; created if missing"
    )
    language.add_argument(
        "--ros", type=Path, metavar="DIR", help="the folder for a ROS 2 package around hard.py; created if missing"
    )
    c = parser.add_argument_group("with --c")
    c.add_argument("--rows", type=int, metavar="N", help="rows of a frame (default: those of the model's eye)")
    c.add_argument("--cols", type=int, metavar="N", help="columns of a frame (default: those of the model's eye)")
    c.add_argument(
        "--degrees-per-pixel",
        type=float,
        metavar="DEGREES",
        help="visual angle of a pixel; goes together with --rows and --cols",
    )
    c.add_argument("--fps", type=float, metavar="N", help="frames per second (default: those of the model's eye)")
    c.add_argument(
        "--ram", type=int, metavar="BYTES", help="refuse what needs more, with the frame that the camera fills"
    )
    c.add_argument("--protocol", metavar="PROTOCOL", help="stimuli for the gap to the hard model (default: lgmd2)")
    c.add_argument(
        "--clip",
        type=Path,
        action="append",
        metavar="CLIP",
        help="a clip on which it is measured too; may be given again",
    )
