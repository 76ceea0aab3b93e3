"""The arguments of `lgmd2jax stimuli PROTOCOL`."""

import argparse
from pathlib import Path

FORMS = ("mp4", "png", "npz")  # of a clip
_EXAMPLES = """\
examples:
  lgmd2jax stimuli looming                        the shipped protocol looming: writes looming.png here
  lgmd2jax stimuli mine.toml                      one of your own: writes mine.png beside mine.toml
  lgmd2jax stimuli paper -o sheets                several pages: sheets/paper-1.png, sheets/paper-2.png, ...
  lgmd2jax stimuli robot --clips mp4              also one film for each condition, in robot-clips/
  lgmd2jax stimuli robot --clips png -o screen    also folders of PNG, 8 bit and lossless, in screen/robot-clips/
  lgmd2jax stimuli robot --clips npz              also arrays: frames (uint8), time_ms, fps, name
  lgmd2jax stimuli video                          labelled clips with their labels; the first of those rendered

A protocol is a TOML file with an eye and a list of conditions:
  [eye]
  preset = "locust"
  [[condition]]
  name = "dark approach {l_over_v} ms"
  family = "looming"
  l_over_v = [20, 40, 80]
  contrast = -0.9
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "stimuli",
        help="draw what a protocol shows, and write its clips",
        description="Draw a contact sheet of a protocol: some frames of each condition and its trajectory.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("protocol", metavar="PROTOCOL", help="a TOML file, or the name of a shipped protocol")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FOLDER",
        help="the folder for the sheet (default: beside the protocol; of a shipped protocol, here)",
    )
    parser.add_argument("--clips", choices=FORMS, help="also write every condition as a clip")
