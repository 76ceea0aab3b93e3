"""Where the results of a recipe and its unfinished work are kept."""

import argparse
import datetime
import platform
import time
from pathlib import Path
from typing import Any

from lgmd2jax._compute.finished_work import FileMemory
from lgmd2jax._files.catalogue import results_folder


def folder_of(options: argparse.Namespace, name: str) -> Path:
    """Where the results of the recipe of this name go."""
    return options.output or results_folder(options.recipe) / name


def starts_of(folder: Path, digest: str, resume: bool) -> FileMemory:
    """What a fit has finished so far, in a hidden file beside the folder of its results."""
    place = folder.absolute()
    return FileMemory(place.with_name(f".{place.name}.starts.jsonl"), digest, resume)


def origin(start: float) -> dict[str, Any]:
    """When and on what a result came about, for fit.json. `start`: of the run, by `time.monotonic`."""
    return {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "seconds": round(time.monotonic() - start, 1),
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
    }
