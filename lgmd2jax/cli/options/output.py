"""How a file to write is named."""

import argparse
from pathlib import Path


def new_file(text: str) -> Path:
    """The path of a file; `Path` alone would drop what tells a folder.

    **Raises:** `ArgumentTypeError` for the name of a folder.
    """
    if text.endswith("/"):
        raise argparse.ArgumentTypeError(f"{text} is the name of a folder; give that of a file")
    return Path(text)
