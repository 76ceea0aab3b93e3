"""Clips decoded once: grey and small, kept in the user's cache for the next fit."""

import dataclasses
import hashlib
import zipfile
from pathlib import Path

import numpy as np

from lgmd2jax._files.atomic import replaced
from lgmd2jax._files.cache import cache_folder
from lgmd2jax._video.clip import Clip
from lgmd2jax._video.recording import Recording
from lgmd2jax._video.remarks import warn

_READER = 2  # another number where the same file comes to be read otherwise


def decode(clip: Clip, path: Path, drop_duplicates: bool, options: tuple = ()) -> Recording:
    """Read the frames of a clip, from the cache where the same file was read in the same way before.

    `options`: what else the frames depend on. A cache that cannot be read or written is done without.
    """
    kept = cache_folder() / "clips" / f"{_digest(clip, path, drop_duplicates, options)}.npz"
    try:
        with open(kept, "rb") as stream, np.load(stream) as file:
            arrays = {name: file[name] for name in ("frames", "index", "time", "interval")}
            return Recording(**arrays, fps=float(file["fps"]), count=int(file["count"]))
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        pass  # not there, or not whole
    recording = clip.record(drop_duplicates)
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        with replaced(kept, is_result=False) as temporary:
            np.savez(temporary, **dataclasses.asdict(recording))
    except (OSError, ValueError) as error:
        warn(f"{clip.name}: it is decoded again in every run, since the cache {kept.parent} cannot be written: {error}")
    return recording


def _digest(clip: Clip, path: Path, drop_duplicates: bool, options: tuple) -> str:
    """Of all that the frames depend on. A folder counts by the pictures in it."""
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    stamps = [(file.name, file.stat().st_size, file.stat().st_mtime_ns) for file in files]
    settings = clip.fps, clip.told, clip.window, clip.shape, drop_duplicates, options, _READER
    return hashlib.sha256(repr((str(path.resolve()), stamps, settings)).encode()).hexdigest()[:32]
