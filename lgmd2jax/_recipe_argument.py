"""A recipe on the command line, and the folder of its results."""

import argparse
from pathlib import Path

from lgmd2jax._catalogue import results_folder


def add_recipe(parser: argparse.ArgumentParser) -> None:
    """The arguments RECIPE and --output."""
    parser.add_argument("recipe", metavar="RECIPE", help="a TOML file, or the name of a shipped recipe")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FOLDER", help="default: beside the recipe; for a shipped one, here"
    )


def folder_of(options: argparse.Namespace, name: str) -> Path:
    """Where the results of the recipe of this name go."""
    return options.output or results_folder(options.recipe) / name
