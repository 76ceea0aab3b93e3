"""The files of a C program, from a model and the templates beside this module."""

import math
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lgmd2jax import hard
from lgmd2jax._eye import Eye
from lgmd2jax._files.templates import rendered, templates
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.parameter_set import declared

_TEMPLATES = Path(__file__).parent / "templates"


class Constant(NamedTuple):
    """A parameter as C says it."""

    name: str
    value: str
    meaning: str


def sources(model: LGMD2, vector: Mapping[str, Any], urgency: Mapping[str, Any] | None = None) -> dict[str, str]:
    """The text of each file, by its path: the network, its test, a Makefile, and an example for a microcontroller.

    **Arguments:** `vector`: the test vector of the model's hand-over file; `urgency`: its calibration, if it has one.

    **Raises:** `ValueError` for a model without an eye, whose frames have no size, and for a parameter that leaves its
    domain in single precision.
    """
    values = {
        "lgmd2.h": (network := _network(model) | {"urgency": urgency and _urgency(urgency)}),
        "lgmd2.c": network,
        "test_vector.h": _test_vector(vector),
        "Makefile": dict(zip(("rows", "cols"), np.shape(vector["frames"])[1:], strict=True)),
    }
    texts = templates(_TEMPLATES)
    return texts | {name: rendered(texts[name], given) for name, given in values.items()}


def file_names() -> tuple[str, ...]:
    """The paths of the files."""
    return tuple(templates(_TEMPLATES))


def mechanisms_of(model: LGMD2) -> tuple[str, ...]:
    """Those that act: a lag and a membrane of 0 ms do nothing, and need no code."""
    times = {"lag": model.parameters.lag, "membrane": model.parameters.tau_cell}
    return tuple(name for name in model.mechanisms if float(times.get(name, 1.0)) > 0)


def frames_of_lag(model: LGMD2) -> int:
    """How many frames the lag reaches back, this one and the one before that moment included."""
    return math.ceil(float(model.parameters.lag) / model.cell.shortest_interval) + 2


def _network(model: LGMD2) -> dict[str, Any]:
    mechanisms = mechanisms_of(model)
    return {
        "program": f"lgmd2jax {version('lgmd2jax')}",
        "mechanisms": mechanisms,
        "n_p": model.n_p,
        "N_ts": model.N_ts,
        "low_pass": model.low_pass,
        "past": frames_of_lag(model),
        "shortest_interval": f"{model.cell.shortest_interval:g}",
        "threshold": "A_ffi" if "size" in mechanisms else "T_ffi",
        "constants": list(_constants(model, mechanisms)),
        "persistence": [_literal(1 / (1 + math.exp(float(model.parameters.u) * (i + 1)))) for i in range(model.n_p)],
        **_eye(model.eye),
    }


def _constants(model: LGMD2, mechanisms: tuple[str, ...]):
    for name, symbol in declared(type(model.parameters)).items():
        if name in model.unused or name == "u" or symbol.mechanism not in (None, *mechanisms):
            continue
        value = float(getattr(model.parameters, name))
        if not symbol.contains(single := np.float32(value)):
            raise ValueError(
                f"{name} is {value:g}, which single precision in C rounds to {single:g}, outside of {symbol.domain}; "
                "choose a value farther from that bound"
            )
        yield Constant(name, _literal(value), symbol.meaning + ("" if symbol.unit == "1" else f" [{symbol.unit}]"))


_WEIGHED = {
    "intercept": "1",
    "smp_adapted": "U' - .5",
    "level": "the low-passed U, less .5",
    "rise": "U less the low-passed U",
    "inhibition": "Fbar/(Fbar + the threshold of the inhibition)",
}


def _urgency(calibration: Mapping[str, Any]) -> dict[str, Any]:
    for name in hard.URGENCY:
        if abs(value := calibration[name]) > float(np.finfo(np.float32).max):
            raise ValueError(f"{name} of the urgency is {value:g}, which single precision cannot hold; calibrate again")
    return {
        "within_ms": calibration["within_ms"],
        "tau_ms": _literal(calibration["tau_ms"]),
        "weights": [Constant(name, _literal(calibration[name]), meaning) for name, meaning in _WEIGHED.items()],
        **{name: list(map(_literal, calibration.get(name, ()))) for name in hard.CALIBRATION},
    }


def _eye(eye: Eye | None) -> dict[str, Any]:
    if eye is None:
        raise ValueError("the model has no eye, so the size of its frames is not known; give it one: LGMD2(..., eye=)")
    degrees = "" if eye.degrees_per_pixel is None else f" of {eye.degrees_per_pixel:g} degrees"
    text = f"{eye.rows} x {eye.cols} pixels{degrees} at {eye.fps:g} frames per second"
    return {"rows": eye.rows, "cols": eye.cols, "eye": text, "interval": _literal(round(1000 / eye.fps, 1))}


def _test_vector(vector: Mapping[str, Any]) -> dict[str, Any]:
    response = [vector["response"][name] for name in hard.CHANNELS]
    largest = [vector["tolerance"] * float(np.abs(channel).max()) for channel in response[:4]]
    return {
        "frames": [np.ravel(frame) for frame in vector["frames"]],
        "interval": _literal(1000 / vector["fps"]),
        "expected": [_output(values) for values in zip(*response, strict=True)],
        "allowed": _output((*largest, 0, False)),
    }


def _output(values) -> list[str]:
    *potentials, spikes, collision = values
    return [*map(_literal, potentials), str(spikes), str(collision).lower()]


def _literal(value: float) -> str:
    """A number as C writes it in single precision, as shortly as that allows."""
    return f"{np.float32(value)!s}f"
