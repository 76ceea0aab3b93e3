"""The peers: found, and checked against the NumPy model before anybody times them."""

import importlib
import time
from collections.abc import Mapping
from types import ModuleType

import numpy as np

from benchmarks._task import FPS, PARAMETERS, VALUES, Size, film
from lgmd2jax.hard import HardLGMD2, Response, first_difference

PACKAGES: Mapping[str, str] = {
    "_numba_loop": "numba",
    "_opencv": "opencv-python-headless",
    "_torch": "torch",
}


def find(module: str) -> ModuleType | None:
    """The module of a peer; None where its package is not installed."""
    try:
        return importlib.import_module(f"benchmarks.{module}")
    except ModuleNotFoundError:
        return None


def check(name: str, respond) -> float:
    """Refuse a peer that computes something else than `lgmd2jax.hard`.

    **Returns:** the seconds of this first call, which compiles where a peer compiles at all.

    **Raises:** `ValueError` that names the first frame and channel that differ.
    """
    frames = film(Size(25, 31), 60)
    began = time.perf_counter()
    response = Response(*map(np.asarray, respond(frames, VALUES, FPS)))
    seconds = time.perf_counter() - began
    found = first_difference(response, HardLGMD2(PARAMETERS, FPS)(frames), tolerance=1e-4)
    if found is not None:
        raise ValueError(f"{name} computes another network: {found[1]} of frame {found[0]} differs; mend it first")
    return seconds
