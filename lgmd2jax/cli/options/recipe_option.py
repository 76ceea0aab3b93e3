"""How the recipe of a command is named, and where its results go."""

import argparse
from pathlib import Path


def add_recipe(parser: argparse.ArgumentParser) -> None:
    """The argument RECIPE and the option --output."""
    parser.add_argument("recipe", metavar="RECIPE", help="a TOML file, or the name of a shipped recipe")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FOLDER",
        help="the folder for the results (default: named as the recipe, beside it; of a shipped recipe, here)",
    )
