"""The hand-over file model.json: what leaves the library for a robot. Its format is read, and checked, by `hard.py`."""

import dataclasses
import json
import math
import os
import re
from collections.abc import Mapping
from importlib.metadata import version

import numpy as np

from lgmd2jax import hard
from lgmd2jax._eye import Eye
from lgmd2jax._files.atomic import replaced
from lgmd2jax._handover.test_vector import make_test_vector
from lgmd2jax._network.abstract import Network
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.parameters import Parameters, symbols
from lgmd2jax._network.structure import structure_of

Plain = str | int | float | bool


def save(model: Network, path: str | os.PathLike, provenance: Mapping[str, Plain] | None = None) -> None:
    """Write the hand-over file: the parameters, for hard thresholds, with structure, eye, version and a test vector.

    Equal models give equal files. A number is written as shortly as its precision allows. Finding a test vector that
    suits the parameters takes about a second.

    **Arguments:** `provenance` is what else the file says of its origin, by name: text, numbers, truth values. Leave
    out what differs between two runs of the same fit, such as the time.

    **Raises:** `ValueError` for a batch of models, for another than an `LGMD2` and for other provenance, `OSError`
    where the file cannot be written.
    """
    model = handed_over(model)
    parameters = {}
    for name in symbols():
        leaf = np.asarray(getattr(model.parameters, name))
        if leaf.shape != ():
            raise ValueError(f"{name} has shape {leaf.shape}; a hand-over file holds one model: pick one of the batch")
        parameters[name] = float(str(leaf))
    eye = None if model.eye is None else dataclasses.asdict(model.eye)
    if eye is not None:
        eye |= {name: float(eye[name]) for name in ("degrees_per_pixel", "fps") if eye[name] is not None}
    structure = structure_of(model)
    content = {
        "format": hard.FORMAT,
        "version": hard.VERSION,
        "parameters": parameters,
        "structure": structure,
        "eye": eye,
        "provenance": {"program": f"lgmd2jax {version('lgmd2jax')}", **_plain(provenance or {})},
        "test_vector": make_test_vector(parameters, structure, None if eye is None else eye["fps"]),
    }
    with replaced(path) as temporary:
        temporary.write_text(_numbers_in_rows(json.dumps(content, indent=2, allow_nan=False)) + "\n", encoding="utf-8")


def handed_over(model: Network) -> LGMD2:
    """The model, where a hand-over file can hold it.

    **Raises:** `ValueError` for another than an `LGMD2`.
    """
    if not isinstance(model, LGMD2):
        raise ValueError(f"the model is a {type(model).__name__}; a hand-over file, and hard.py, hold an LGMD2")
    return model


def load(path: str | os.PathLike) -> LGMD2:
    """The model of a hand-over file, with hard thresholds, once `hard.py` finds that its test vector comes out.

    **Raises:** `ValueError` that says what is wrong with the file, `OSError` where it cannot be read.
    """
    content = hard.read(path)
    try:
        eye = None if content["eye"] is None else Eye(**content["eye"])
        return LGMD2(Parameters(**content["parameters"]), eye=eye, **content["structure"])
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path} is not a hand-over file that can be used: {error}") from None


def _plain(provenance):
    for name, value in provenance.items():
        number = isinstance(value, (int, float)) and math.isfinite(value)
        if name == "program" or not isinstance(name, str) or not (isinstance(value, str) or number):
            raise ValueError(
                f"provenance has {name!r}: {value!r}; give names other than 'program', "
                "with text, finite numbers or truth values"
            )
    return dict(sorted(provenance.items()))


def _numbers_in_rows(text):
    """Indented JSON with each innermost list of numbers on one line. Strings hold no line breaks, so they stay."""

    def on_one_line(found):
        return f"[{' '.join(found[1].split())}]"

    return re.sub(r'\[\n([^\[\]{}"]*)\]', on_one_line, text)
