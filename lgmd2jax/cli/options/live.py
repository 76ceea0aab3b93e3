"""The arguments of `lgmd2jax live SOURCE`."""

import argparse

from lgmd2jax.cli.options.frames_option import add_frame_options
from lgmd2jax.cli.options.model_option import add_model
from lgmd2jax.cli.options.output import new_file

_EXAMPLES = """\
examples:
  lgmd2jax live 0                                  the first camera, until Ctrl-C
  lgmd2jax live /dev/video2 --model video          another one, with the shipped model that was fitted to clips
  lgmd2jax live udp://0.0.0.0:5000                 what is sent to port 5000 of this machine
  lgmd2jax live tcp://robot:5000 --csv drive.csv   a robot's stream, and the numbers of every frame into a file
  gst-launch-1.0 -q ... ! fdsink | lgmd2jax live - a pipe, of anything that ffmpeg reads

A frame that comes while another one is computed is dropped rather than delayed, and the model takes the true interval
between the frames that it gets. Latency counts from the arrival of a frame's bytes to the verdict. In a terminal the
trace of the adapted potential runs along (with rich: pip install 'lgmd2jax[live]'); into a file or a pipe go plain
lines, one a second and one at each alarm.

Ctrl-C and the end of the stream end it well: files are whole, and a summary says what came.
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "live",
        help="run a model on a camera or a stream",
        description="Run a model on a camera, a stream or a pipe while it runs: trace and alarm in the terminal.",
        epilog=_EXAMPLES,
    )
    parser.add_argument(
        "source", metavar="SOURCE", help="0 or /dev/video0 for a camera, a udp:// or tcp:// stream, - for a pipe"
    )
    add_model(parser)
    parser.add_argument(
        "--csv", type=new_file, metavar="FILE", help="also write a row for each frame that the model saw"
    )
    parser.add_argument(
        "--overlay", type=new_file, metavar="FILE", help="also write a video with trace and alarm drawn on it"
    )
    add_frame_options(parser, "99")
    parser.add_argument(
        "--timeout", type=float, default=5.0, metavar="S", help="seconds without a frame that end it (default: 5)"
    )
