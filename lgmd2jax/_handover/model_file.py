"""The hand-over file model.json: what leaves the library for a robot."""

import dataclasses
import json
import os
import re
import sys
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from lgmd2jax import hard
from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._files.atomic import read_json, replaced
from lgmd2jax._handover.response_vector import response_vector
from lgmd2jax._handover.test_vector import make_test_vector
from lgmd2jax._network.abstract import AbstractNetwork, parameters_of
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.networks import NETWORKS
from lgmd2jax._network.parameter_set import declared
from lgmd2jax._network.structure import structure_fields, structure_of
from lgmd2jax._network.thresholds import Hard
from lgmd2jax._schemas.check import check
from lgmd2jax._schemas.model_file import MODEL_FILE
from lgmd2jax._words import nearest, within

Plain = str | int | float | bool


@checked
def save(model: AbstractNetwork, path: str | os.PathLike, provenance: Mapping[str, Plain] | None = None) -> None:
    """Write the hand-over file: the parameters, for hard thresholds, with structure, eye, version and a test vector.

    Equal models give equal files. A number is written as shortly as its precision allows. Finding a test vector that
    suits the parameters takes about a second. A network of your own is written by the name of its class.

    **Arguments:** `provenance` is what else the file says of its origin, by name: text, numbers, truth values. Leave
    out what differs between two runs of the same fit, such as the time.

    **Raises:** `ValueError` for a batch of models and for other provenance, `OSError` where the file cannot be written.
    """
    _write(document(model, provenance), path)


def _write(content: Mapping[str, Any], path: str | os.PathLike) -> None:
    with replaced(path) as temporary:
        temporary.write_text(_numbers_in_rows(json.dumps(content, indent=2, allow_nan=False)) + "\n", encoding="utf-8")


def document(model: AbstractNetwork, provenance: Mapping[str, Plain] | None = None) -> dict[str, Any]:
    """What the hand-over file holds.

    **Raises:** `ValueError` as `save`.
    """
    model = dataclasses.replace(model, thresholds=Hard())
    parameters, mechanisms = _values(model)
    eye = None if model.eye is None else dataclasses.asdict(model.eye)
    if eye is not None:
        eye |= {name: float(eye[name]) for name in ("degrees_per_pixel", "fps") if eye[name] is not None}
    structure = {name: value for name, value in structure_of(model).items() if name != "mechanisms"}
    fps = None if eye is None else eye["fps"]
    vector = make_test_vector(as_hard(model), fps) if isinstance(model, LGMD2) else response_vector(model, fps)
    return {
        "format": hard.FORMAT,
        "version": hard.VERSION,
        "network": type(model).__name__,
        "parameters": parameters,
        **({"mechanisms": mechanisms} if mechanisms else {}),
        "structure": structure,
        "eye": eye,
        "provenance": {"program": f"lgmd2jax {version('lgmd2jax')}", **_plain(provenance or {})},
        "test_vector": vector,
    }


def calibrate(path: str | os.PathLike, name: str, values: Mapping[str, Any]) -> None:
    """Put a calibration into a hand-over file, in the place of one of this name; all else stays as it is.

    A file of version 1, which has no calibration, becomes one of version 2.

    **Raises:** as `load`, and for values that the file may not hold.
    """
    path = Path(path)
    content = read_json(path)
    with within(f"{path} is not a hand-over file that can be used"):
        check(MODEL_FILE, content)
        head = {"format": hard.FORMAT, "version": hard.VERSION, "network": content.get("network", LGMD2.__name__)}
        calibration = content.get("calibration", {}) | {name: dict(values)}
        others = {key: value for key, value in content.items() if key not in (*head, "calibration", "test_vector")}
        content = head | others | {"calibration": calibration, "test_vector": content["test_vector"]}
        check(MODEL_FILE, content)
    _write(content, path)


def calibration_of(path: str | os.PathLike) -> Mapping[str, Any]:
    """The calibrations in a hand-over file, by name.

    **Raises:** as `load`.
    """
    path = Path(path)
    content = read_json(path)
    with within(f"{path} is not a hand-over file that can be used"):
        check(MODEL_FILE, content)
    return content.get("calibration", {})


@checked
def load(path: str | os.PathLike, network: type[AbstractNetwork] | None = None) -> Any:
    """The model of a hand-over file, with hard thresholds, once its test vector has come out.

    **Arguments:** `network`: the class of a network of your own; what the library has is found by its name.

    **Raises:** `ValueError` that says what is wrong with the file, `OSError` where it cannot be read.
    """
    path = Path(path)
    content = read_json(path)
    with within(f"{path} is not a hand-over file that can be used"):
        check(MODEL_FILE, content)
        kind = _kind(content.get("network", LGMD2.__name__), network)
        return _built(kind, hard.checked(content)) if kind is LGMD2 else _proved(kind, content)


def _proved(kind: type[AbstractNetwork], content: Mapping[str, Any]) -> AbstractNetwork:
    """The model, which answers the test vector as the file says."""
    vector = content["test_vector"]
    hard.check_test_vector(vector, content["eye"])
    model = _built(kind, content)
    response = model(np.array(vector["frames"], float), vector["fps"])
    hard.prove(hard.Response(*(np.asarray(getattr(response, name)) for name in hard.CHANNELS)), vector)
    return model


def as_lgmd2(model: AbstractNetwork) -> LGMD2:
    """The model, where a robot's program can run it.

    **Raises:** `ValueError` for another than an `LGMD2`.
    """
    if not isinstance(model, LGMD2):
        raise ValueError(f"the model is a {type(model).__name__}; hard.py and the C code run only the LGMD2")
    return model


def as_hard(model: LGMD2) -> hard.HardLGMD2:
    """The model as a robot's program runs it, without a frame rate: every step is given its interval."""
    parameters, mechanisms = _values(model)
    for values in mechanisms.values():
        parameters |= values
    structure = {name: value for name, value in structure_of(model).items() if name != "mechanisms"}
    return hard.HardLGMD2(parameters, mechanisms=tuple(mechanisms), **structure)


def _values(model: AbstractNetwork) -> tuple[dict[str, float], dict[str, dict[str, float]]]:
    """The parameters of the network as it always is, and those of each mechanism that it has."""
    parameters, mechanisms = {}, {name: {} for name in structure_of(model).get("mechanisms", ())}
    for name, symbol in declared(type(model.parameters)).items():
        leaf = np.asarray(getattr(model.parameters, name))
        if leaf.shape != ():
            raise ValueError(f"{name} has shape {leaf.shape}; a hand-over file holds one model: pick one of the batch")
        if symbol.mechanism is None:
            parameters[name] = float(str(leaf))
        elif symbol.mechanism in mechanisms:
            mechanisms[symbol.mechanism][name] = float(str(leaf))
    return parameters, mechanisms


def _kind(name: str, network: type[AbstractNetwork] | None) -> type[AbstractNetwork]:
    if network is not None:
        if network.__name__ != name:
            raise ValueError(f"its network is {name!r}, not {network.__name__!r}")
        return network
    if name not in NETWORKS:
        raise ValueError(
            f"its network is {name!r}; for one of your own give its class, in Python: load(path, network={name}) or "
            f"load_fit(folder, network={name}); commands know the library's own, {', '.join(NETWORKS)}"
        )
    return NETWORKS[name]


def _built(kind: type[AbstractNetwork], content: Mapping[str, Any]) -> AbstractNetwork:
    eye = None if content["eye"] is None else Eye(**content["eye"])
    values, mechanisms = dict(content["parameters"]), content.get("mechanisms", {})
    for table in mechanisms.values():
        values |= table
    known = declared(parameters_of(kind))
    for name in values:
        if name not in known:
            raise ValueError(f"parameter {name} is unknown; choose {nearest(name, known)}")
    for name, symbol in known.items():
        if name not in values and symbol.mechanism in (None, *mechanisms):
            raise ValueError(f"parameter {name} is missing")
    structure = {
        name: tuple(value) if isinstance(value, list) else value for name, value in content["structure"].items()
    }
    for name in structure:
        if name not in (static := structure_fields(kind)):
            raise ValueError(f"structure {name} is unknown; choose {nearest(name, static)}")
    if "mechanisms" in structure_fields(kind):
        structure["mechanisms"] = tuple(mechanisms)
    elif mechanisms:
        raise ValueError(f"mechanism {next(iter(mechanisms))} is unknown; a {kind.__name__} has none")
    parameters: Any = parameters_of(kind)
    build: Any = kind
    return build(parameters(**{name: float(value) for name, value in values.items()}), eye=eye, **structure)


def _plain(provenance):
    for name, value in provenance.items():
        number = isinstance(value, (int, float)) and abs(value) <= sys.float_info.max
        if name == "program" or not isinstance(name, str) or not (isinstance(value, str) or number):
            raise ValueError(
                f"provenance has {name!r}: {value!r}; give names other than 'program', "
                "with text, finite numbers or truth values"
            )
    return dict(sorted(provenance.items()))


def _numbers_in_rows(text):
    """Indented JSON with each innermost list of numbers on one line. Strings hold no line breaks, so they stay."""

    def on_one_line(match):
        return f"[{' '.join(match[1].split())}]"

    return re.sub(r'\[\n([^\[\]{}"]*)\]', on_one_line, text)
