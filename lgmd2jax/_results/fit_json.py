"""fit.json: a fit as plain data, and back."""

import dataclasses
import math
from importlib.metadata import version
from typing import Any

import jax
import numpy as np

from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.thresholds import Soft, StraightThrough, Thresholds, Widths
from lgmd2jax._targets.observation import Observation, observation_symbols
from lgmd2jax.fitting import Curve, Fit, Free, Linear, Log, Run, Supplement, Tie, Uncertainty
from lgmd2jax.fitting._bounds import RANGES
from lgmd2jax.fitting._curve import tallies
from lgmd2jax.fitting._uncertainty.covariance import CONFIDENCE

FORMAT, VERSION = "lgmd2jax-fit", 1


def content_of(fit: Fit, supplement: Supplement) -> dict[str, Any]:
    """All but the curves and the model, which have files of their own; numbers that are not finite as None."""
    u = fit.uncertainty
    free = {
        parameter.name: {
            "value": fit.values[parameter.name],
            "standard_error": u.standard_errors[i],
            "interval": u.intervals[i],
            "determined": bool(u.determined[i]),
            "on_bound": int(u.on_bound[i]),
            "unit": parameter.symbol.unit,
            "start": fit.start[parameter.name],
            "low": parameter.low,
            "high": parameter.high,
            "scale": parameter.scale,
            "prior": parameter.prior,
        }
        for i, parameter in enumerate(fit.free.parameters)
    }
    observation = {name: float(getattr(fit.observation, name)) for name in observation_symbols()}
    content = {
        "format": FORMAT,
        "version": VERSION,
        "result": fit.result,
        "status": fit.status,
        "unfinished": supplement.unfinished,
        "free": free,
        "ties": {name: dataclasses.asdict(tie) for name, tie in fit.free.ties.items()},
        "observation": observation,
        "loss": fit.loss,
        "soft_loss": fit.soft_loss,
        "temperatures": fit.temperatures,
        "thresholds": _thresholds(fit.model.thresholds),
        "curves": [
            {
                "condition": curve.condition,
                "channel": curve.channel,
                "r2": {"soft": curve.r2("soft"), "hard": curve.r2("hard")},
                "rmse": {kind: curve.rmse(kind) for kind in ("soft", "hard", "silence")},
                "gap": curve.gap,
                "grade": curve.grade,
            }
            | _band(curve)
            for curve in fit.curves
        ],
        "remarks": fit.remarks(),
        "leave_one_out_r2": supplement.left_out,
        "looming_law": supplement.looming_law and dataclasses.asdict(supplement.looming_law),
        "profiles": {name: dataclasses.asdict(profile) for name, profile in supplement.profiles.items()},
        "score_test": [score._asdict() for score in supplement.scores],
        "z": fit.z,
        "uncertainty": _plain_uncertainty(u),
        "curved": fit.nonlinear,
        "errors": fit.errors,
        "stats": fit.stats,
        "runs": [dataclasses.asdict(run) for run in fit.runs],
        "screened": fit.screened,
        "versions": {name: version(name) for name in ("lgmd2jax", "jax", "equinox", "optimistix", "numpy")},
    }
    if words := tallies(fit.curves):
        content["words"] = [tally._asdict() for tally in words]
    return plain(content)


def fit_of(content: dict[str, Any], model: AbstractNetwork, curves: tuple[Curve, ...]) -> Fit:
    """The fit, with the hard model of its hand-over file and its curves, from content whose form is checked.

    **Raises:** `ValueError` for what does not fit together.
    """
    thresholds = content["thresholds"]
    if thresholds["kind"] != "Hard":
        kind = {"Soft": Soft, "StraightThrough": StraightThrough}[thresholds["kind"]]
        model = dataclasses.replace(model, thresholds=kind(thresholds["temperature"], Widths(**thresholds["widths"])))
    choices = {name: _choice(entry) for name, entry in content["free"].items()}
    if len(content["z"]) != len(choices):
        raise ValueError(f"z has {len(content['z'])} values, but {len(choices)} parameters are free")
    written = [(entry["condition"], entry["channel"]) for entry in content["curves"]]
    if written != [(curve.condition, curve.channel) for curve in curves]:
        raise ValueError("curves.csv holds other curves than fit.json names; take both from one fit")
    return Fit(
        model=model,
        observation=Observation(**content["observation"]),
        free=Free(**choices, **{name: Tie(**tie) for name, tie in content["ties"].items()}),
        z=np.array(content["z"]),
        start={name: entry["start"] for name, entry in content["free"].items()},
        loss=content["loss"],
        soft_loss=content["soft_loss"],
        temperatures=tuple(content["temperatures"]),
        uncertainty=_uncertainty(tuple(choices), content["uncertainty"]),
        nonlinear=tuple(content["curved"]),
        curves=tuple(
            dataclasses.replace(curve, quote=entry.get("quote", ""))
            for curve, entry in zip(curves, content["curves"], strict=True)
        ),
        runs=tuple(Run.of(run) for run in content["runs"]),
        screened=tuple(content["screened"]),
        errors=content["errors"],
        result=content["result"],
        stats=content["stats"],
    )


def _band(curve: Curve) -> dict[str, Any]:
    """What is told of a band alone."""
    if not curve.is_band:
        return {}
    within = {kind: curve.inside(kind) for kind in ("soft", "hard", "silence")}
    return {"quote": curve.quote, "within": within}


def _choice(entry: dict[str, Any]) -> Linear | Log:
    return RANGES[entry["scale"]](entry["low"], entry["high"], entry["prior"] and tuple(entry["prior"]))


def _thresholds(thresholds: Thresholds) -> dict[str, Any]:
    if not isinstance(thresholds, Soft | StraightThrough):
        return {"kind": "Hard"}
    widths = {field.name: float(getattr(thresholds.widths, field.name)) for field in dataclasses.fields(Widths)}
    return {"kind": type(thresholds).__name__, "temperature": float(thresholds.temperature), "widths": widths}


def _plain_uncertainty(u: Uncertainty) -> dict[str, Any]:
    """All but the names; the confidence of the intervals follows them."""
    content: dict[str, Any] = {}
    for field in dataclasses.fields(u):
        if field.name != "names":
            content[field.name] = getattr(u, field.name)
        if field.name == "intervals":
            content["confidence"] = CONFIDENCE
    return content


def _uncertainty(names: tuple[str, ...], content: dict[str, Any]) -> Uncertainty:
    fields: dict[str, Any] = {"names": names}
    for field in dataclasses.fields(Uncertainty):
        if field.name == "names":
            continue
        value = content[field.name]
        if (axes := getattr(field.type, "dim_str", None)) is not None:
            shape = [len(names) if axis == "free" else int(axis) for axis in axes.split()]
            if not _has_shape(value, shape):
                raise ValueError(f"uncertainty.{field.name} does not have the shape {shape} of {len(names)} parameters")
        fields[field.name] = _array(value, math.inf if field.name == "standard_errors" else math.nan)
    return Uncertainty(**fields)


def _has_shape(value: Any, shape: list[int]) -> bool:
    """Whether nested lists have these lengths."""
    if not isinstance(value, list):
        return not shape
    return bool(shape) and len(value) == shape[0] and all(_has_shape(part, shape[1:]) for part in value)


def _array(value: Any, beyond: float) -> Any:
    """Lists as arrays, and None, since JSON has no word for it, as `beyond`."""
    if isinstance(value, list):
        return np.array([_array(entry, beyond) for entry in value])
    return beyond if value is None else value


def plain(value: Any) -> Any:
    """As JSON has it: arrays as lists, what is not finite as null."""
    if isinstance(value, dict):
        return {name: plain(entry) for name, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, (np.ndarray, np.generic, jax.Array)):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
