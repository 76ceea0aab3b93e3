"""Clips of a protocol for other software: films, folders of pictures, arrays."""

import contextlib
import os
import re
import secrets
import shutil
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import imageio.v3 as iio
import numpy as np
from jaxtyping import UInt8

from lgmd2jax._files.written import note
from lgmd2jax._video.writer import video_writer
from lgmd2jax.stimuli import Stimulus

_OURS = re.compile(r"\d{3,}-")


def write_clip(stimulus: Stimulus, form: str, folder: Path, number: int) -> None:
    """Write one clip, named by its number and its condition, in one of the `FORMS`."""
    slug = re.sub(r"[^\w.+=-]+", "-", stimulus.name).strip("-.")
    FORMS[form](stimulus, folder / f"{number:03d}-{slug}")


@contextlib.contextmanager
def clips_folder(path: Path) -> Iterator[Path]:
    """A new folder that becomes `path` when the block ends well, instead of the clips of an earlier run.

    **Raises:** `ValueError` when `path` is something else than a folder of clips.
    """
    if path.exists() and not (path.is_dir() and all(_OURS.match(item.name) for item in path.iterdir())):
        raise ValueError(f"{path} exists and holds more than clips; move it, or write elsewhere with -o")
    temporary, old = (path.with_name(f".{path.name}.{secrets.token_hex(4)}") for _ in range(2))
    temporary.mkdir()
    try:
        yield temporary
        if path.exists():
            os.replace(path, old)
        os.replace(temporary, path)
        note(path)
    finally:
        for leftover in (temporary, old):
            shutil.rmtree(leftover, ignore_errors=True)


def _pixels(stimulus: Stimulus) -> UInt8[np.ndarray, "time row col"]:
    return np.round(np.clip(np.asarray(stimulus.frames), 0, 255)).astype(np.uint8)


def _film(stimulus: Stimulus, path: Path) -> None:
    with video_writer(path.with_name(f"{path.name}.mp4"), stimulus.fps) as writer:
        for frame, time in zip(_pixels(stimulus), np.asarray(stimulus.time - stimulus.time[0]), strict=True):
            writer.write(np.repeat(frame[..., None], 3, axis=2), float(time))


def _pictures(stimulus: Stimulus, path: Path) -> None:
    path.mkdir()
    for i, frame in enumerate(_pixels(stimulus)):
        iio.imwrite(path / f"{i:05d}.png", frame)


def _arrays(stimulus: Stimulus, path: Path) -> None:
    np.savez_compressed(
        path.with_name(f"{path.name}.npz"),
        frames=_pixels(stimulus),
        time_ms=np.asarray(stimulus.time),
        fps=stimulus.fps,
        name=stimulus.name,
    )


FORMS: Mapping[str, Callable[[Stimulus, Path], None]] = {"mp4": _film, "png": _pictures, "npz": _arrays}
