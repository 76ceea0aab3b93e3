"""How commands that run a model on pictures cut and shrink them."""

import argparse


def add_frame_options(parser: argparse.ArgumentParser, width_without_eye: str) -> None:
    """Add --resize and --crop. **Arguments:** `width_without_eye`: of a model that has none, in words."""
    parser.add_argument(
        "--resize",
        type=int,
        metavar="N",
        help="width in pixels of what the model sees, after the crop "
        f"(default: that of the model's eye; without an eye {width_without_eye})",
    )
    parser.add_argument(
        "--crop",
        metavar="TOP:BOTTOM,LEFT:RIGHT",
        help="rows and columns to use, counted from 0 in pixels of the file; an end may be left out",
    )
