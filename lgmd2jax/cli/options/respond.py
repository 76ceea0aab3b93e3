"""The arguments of `lgmd2jax respond CLIP`."""

import argparse
from pathlib import Path

from lgmd2jax.cli.options.frames_option import add_frame_options
from lgmd2jax.cli.options.model_option import add_model
from lgmd2jax.cli.options.output import new_file

_EXAMPLES = """\
examples:
  lgmd2jax respond crash.mp4                              writes crash.csv and crash.png here
  lgmd2jax respond crash.mp4 --resize 108 --set T_sp=.65  as on the robot: small frames, a low spike threshold
  lgmd2jax respond dashcam.mp4 --drop-duplicates          a file whose frame rate was converted
  lgmd2jax respond film.mp4 --crop :,36:397               without the black bars left and right
  lgmd2jax respond crash.mp4 --model preset:yue_rind      the LGMD1 that the paper compares with
  lgmd2jax respond frames/ --fps 100                      a folder of images
  lgmd2jax respond stack.tif --fps 100 --white 4095       the pages of a TIFF file, from a camera of 12 bits
  lgmd2jax respond crash.mp4 --overlay crash-lgmd2.mp4    also the clip with potential and alarm drawn on it

The CSV file has a row a frame: frame, time_ms; summed potential (mp) and feed-forward inhibition (ffi), in grey levels,
where inhibition codes size ffi as a share of the field, 0 to 1; sigmoid membrane potential before and after adaptation
(smp, smp_adapted); spikes; collision (1 in an alarm).

Any video that ffmpeg reads will do. The clip is read frame by frame, so its length does not matter; --drop-duplicates
reads it twice. Parameters belong to a frame rate and a field of view: those of the presets are meant for 30 fps, and a
fitted model sees a clip as wide as the eye that it was fitted with.
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "respond",
        help="run a model on a video or a folder of images",
        description="Run a model on a video or a folder of images: a CSV file, a figure and, if asked, a video.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("clip", metavar="CLIP", type=Path, help="a video file, or a folder of images in natural order")
    add_model(parser)
    parser.add_argument(
        "--csv", type=new_file, metavar="FILE", help="the numbers (default: CLIP's name with .csv, here)"
    )
    parser.add_argument(
        "--figure", type=new_file, metavar="FILE", help="the figure (default: CLIP's name with .png, here)"
    )
    parser.add_argument(
        "--overlay", type=new_file, metavar="FILE", help="also write the clip with potential and alarm drawn on it"
    )
    parser.add_argument("--fps", type=float, metavar="N", help="frames per second (default: the file's own clock)")
    add_frame_options(parser, "that of the clip")
    parser.add_argument("--drop-duplicates", action="store_true", help="pass over frames that repeat the one before")
    parser.add_argument(
        "--white", type=float, metavar="LEVEL", help="the value that is white (default: the largest of the format)"
    )
    parser.add_argument("--until-damage", action="store_true", help="end a damaged file at its damage, not in an error")
