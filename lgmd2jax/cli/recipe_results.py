"""What commands that take a recipe share: its folder, its unfinished work, and whether eyes are alike."""

import argparse
import contextlib
import datetime
import platform
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, NoReturn

from tqdm import tqdm

from lgmd2jax._compute.finished_work import FileMemory
from lgmd2jax._eye import Eye
from lgmd2jax._files.catalogue import results_folder
from lgmd2jax._files.folder import check_folder
from lgmd2jax._files.lock import locked
from lgmd2jax._files.temporary import temporaries_beside
from lgmd2jax._recipes.fit import Recipe
from lgmd2jax._results.fit_data import entry_naming
from lgmd2jax._results.results_folder import MARKER, is_finished
from lgmd2jax.alarms import AlarmRecipe


def folder_of(options: argparse.Namespace, name: str) -> Path:
    """Where the results of the recipe of this name go."""
    return options.output or results_folder(options.recipe) / name


def clips_bar(jobs: Iterable) -> Iterable:
    """A bar while labelled clips are decoded and rendered."""
    return tqdm(jobs, "clips", unit="source", leave=False, disable=None)


def check_eyes(one: Eye, of_one: str, other: Eye, of_other: str, cure: str) -> None:
    """Refuse eyes of two rates or scales: a model's parameters belong to one of each. Their fields may differ."""
    for name in ("fps", "degrees_per_pixel"):
        if getattr(one, name) != getattr(other, name):
            raise ValueError(
                f"{of_one} has {name} = {getattr(one, name)}, but {of_other} has {getattr(other, name)}; {cure}"
            )


@contextlib.contextmanager
def kept_work(folder: Path, digest: str, resume: bool) -> Iterator[FileMemory]:
    """What a fit has finished so far, in a hidden file beside the folder of its results, which is locked meanwhile.

    The file goes when the block ends well. On Ctrl-C the command says how to go on, and ends.

    **Raises:** `ValueError` for a folder of something else, one in use, and for the work of another recipe.
    """
    check_folder(folder, MARKER)
    place = folder.absolute().with_name(f".{folder.absolute().name}.starts.jsonl")
    with locked(folder):
        for left_over in temporaries_beside(place):
            left_over.unlink()
        memory = FileMemory(place, digest, resume)
        try:
            yield memory
        except KeyboardInterrupt:
            if not memory:
                raise
            print("stopped; what is finished is kept: continue with --resume")
            raise SystemExit(130) from None
        memory.forget()


def write_stopped(folder: Path, write: Callable[[], None], summary: str) -> NoReturn:
    """Write the best of a search that was stopped, unless it would replace finished results, and end the command."""
    print(summary)
    if is_finished(folder):
        print(f"\nstopped by hand; {folder}/ keeps the finished results of an earlier run: continue with --resume")
    else:
        write()
        print(f"\nstopped by hand; {folder}/ holds the best so far: continue with --resume")
    raise SystemExit(130)


def records(
    recipe: Recipe | AlarmRecipe, digest: str, start: float, folder: Path
) -> tuple[dict[str, Any], dict[str, Any]]:
    """What a fit came from: notes for fit.json, and provenance for model.json, which equal fits share.

    **Arguments:** `start`: of the run, by `time.monotonic`. `folder`: of the results.
    """
    notes = {"recipe": recipe.table, "digest": digest, "made": _origin(start)}
    if isinstance(recipe, Recipe):
        notes["data"] = entry_naming(recipe.protocol, folder, recipe.animal)
    return notes, {"recipe": recipe.name, "seed": recipe.seed, "digest": digest}


def _origin(start: float) -> dict[str, Any]:
    """When and on what a result came about."""
    return {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "seconds": round(time.monotonic() - start, 1),
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
    }
