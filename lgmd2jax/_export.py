"""The hand-over file model.json: what leaves the library for a robot. Its format is read, and checked, by `hard.py`."""

import dataclasses
import json
import os
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import numpy as np

from lgmd2jax import hard
from lgmd2jax._eye import Eye
from lgmd2jax._files import replaced
from lgmd2jax._model import LGMD2
from lgmd2jax._parameters import Parameters, symbols


def save(model: LGMD2, path: str | os.PathLike, provenance: Mapping[str, Any] | None = None) -> None:
    """Write the hand-over file: the parameters, for hard thresholds, with structure, eye and version.

    Equal models give equal files. A number is written as shortly as its precision allows.

    **Raises:** `ValueError` for a batch of models, `OSError` where the file cannot be written.
    """
    parameters = {}
    for name in symbols():
        leaf = np.asarray(getattr(model.parameters, name))
        if leaf.shape != ():
            raise ValueError(f"{name} has shape {leaf.shape}; a hand-over file holds one model: pick one of the batch")
        parameters[name] = float(str(leaf))
    content = {
        "format": hard.FORMAT,
        "version": hard.VERSION,
        "parameters": parameters,
        "structure": {"n_p": model.n_p, "low_pass": model.low_pass, "N_ts": model.N_ts},
        "eye": None if model.eye is None else dataclasses.asdict(model.eye),
        "provenance": {"program": f"lgmd2jax {version('lgmd2jax')}", **(provenance or {})},
    }
    with replaced(path) as temporary, open(temporary, "w", encoding="utf-8") as file:
        json.dump(content, file, indent=2, allow_nan=False)
        file.write("\n")


def load(path: str | os.PathLike) -> LGMD2:
    """The model of a hand-over file, with hard thresholds.

    **Raises:** `ValueError` that says what is wrong with the file, `OSError` where it cannot be read.
    """
    content = hard.read(path)
    try:
        eye = None if content["eye"] is None else Eye(**content["eye"])
        return LGMD2(Parameters(**content["parameters"]), eye=eye, **content["structure"])
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path} is not a hand-over file that can be used: {error}") from None
