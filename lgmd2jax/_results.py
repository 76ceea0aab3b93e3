"""The results of a fit as a folder, and back."""

import csv
import dataclasses
import json
import math
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from lgmd2jax._catalogue import locate
from lgmd2jax._export import load, save
from lgmd2jax._folder import replaced_folder
from lgmd2jax._observation import Observation, observation_symbols
from lgmd2jax._thresholds import Hard, Soft, StraightThrough, Thresholds, Widths
from lgmd2jax.fitting import Curve, Fit, Free, Linear, Log, Run, Tie
from lgmd2jax.fitting._report import Extra
from lgmd2jax.fitting._uncertainty import Uncertainty

MARKER = "fit.json"
OWN = (
    "model.json",
    MARKER,
    "curves.csv",
    "fit.png",
    "diagnostics.png",
    "report.txt",
    "report.html",
    "posterior.nc",
)
_FORMAT = "lgmd2jax-fit"
_COLUMNS = ("target", "sem", "weight", "soft", "hard", "band")


def save_fit(
    fit: Fit,
    folder: str | Path,
    *,
    name: str | None = None,
    extra: Extra | None = None,
    provenance: dict[str, Any] | None = None,
    made: dict[str, Any] | None = None,
) -> None:
    """Write a fit's folder: model.json, fit.json, curves.csv, fit.png, diagnostics.png, report.txt and report.html.

    The folder appears whole; an old one of results is replaced in one step, and what else stands in it is kept.

    **Arguments:** `name`: of the report, by default the folder's. `extra`: further sections of the report.
    `provenance`: plain values for model.json, which equal fits share. `made`: what else fit.json is to say.

    **Raises:** `ValueError` for a folder that holds something else, or that cannot be written.
    """
    from lgmd2jax._figures_fit import diagnostics_figure, fit_figure  # the only part that needs matplotlib
    from lgmd2jax._report_page import report_page

    folder, extra = Path(folder), extra or Extra()
    name = name or folder.absolute().name
    with replaced_folder(folder, MARKER, OWN) as new:
        save(fit.model, new / "model.json", provenance=provenance or {})
        _write_curves(new / "curves.csv", fit.curves)
        content = {"format": _FORMAT, "version": 1, "name": name} | _content(fit, extra) | (made or {})
        (new / MARKER).write_text(json.dumps(_plain(content), indent=1, allow_nan=False) + "\n", encoding="utf-8")
        (new / "report.txt").write_text(fit.summary(extra) + "\n", encoding="utf-8")
        fit_figure(new / "fit.png", fit.curves, name)
        diagnostics_figure(new / "diagnostics.png", fit)
        page = report_page(fit, name, [new / "fit.png", new / "diagnostics.png"], extra)
        (new / "report.html").write_text(page, encoding="utf-8")


def load_fit(folder: str | Path) -> Fit:
    """The fit of a result folder, or of a shipped one by its bare name. It predicts; it does not hold the targets.

    **Raises:** `ValueError` for a folder that holds no fit, `FileNotFoundError` where there is none.
    """
    folder = _folder(folder)
    try:
        content = json.loads((folder / MARKER).read_text(encoding="utf-8"))
        if not isinstance(content, dict) or content.get("format") != _FORMAT or content.get("version") != 1:
            raise ValueError(f"its format is not {_FORMAT!r}, version 1")
        return _fit(content, folder)
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{folder} holds no fit that can be used: {error}") from error


def _folder(folder: str | Path) -> Path:
    path = Path(folder)
    if path.is_dir():
        if not (path / MARKER).is_file():
            raise ValueError(f"{path} holds no fit: there is no {MARKER}")
        return path
    return locate(folder, "fits", f"/{MARKER}").parent


def _content(fit: Fit, extra: Extra) -> dict[str, Any]:
    u = fit.uncertainty
    free = {
        it.name: {
            "value": fit.values[it.name],
            "standard_error": u.standard_errors[i],
            "interval": u.intervals[i],
            "determined": bool(u.determined[i]),
            "on_bound": int(u.on_bound[i]),
            "unit": it.symbol.unit,
            "start": fit.start[it.name],
            "low": it.low,
            "high": it.high,
            "scale": it.scale,
            "prior": it.prior,
        }
        for i, it in enumerate(fit.free.freedoms)
    }
    observation = {name: float(getattr(fit.observation, name)) for name in observation_symbols()}
    return {
        "result": fit.result,
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
                "rmse": {"soft": curve.rmse("soft"), "hard": curve.rmse("hard")},
                "gap": curve.gap,
            }
            for curve in fit.curves
        ],
        "remarks": fit.remarks(),
        "leave_one_out_r2": extra.left_out,
        "profiles": {name: dataclasses.asdict(profile) for name, profile in extra.profiles.items()},
        "z": fit.z,
        "uncertainty": {
            field.name: getattr(u, field.name) for field in dataclasses.fields(u) if field.name not in ("names",)
        },
        "errors": fit.errors,
        "stats": fit.stats,
        "runs": [dataclasses.asdict(run) for run in fit.runs],
        "screened": fit.screened,
        "versions": {name: version(name) for name in ("lgmd2jax", "jax", "equinox", "optimistix", "numpy")},
    }


def _fit(content: dict[str, Any], folder: Path) -> Fit:
    model = load(folder / "model.json")
    kind = content["thresholds"]["kind"]
    thresholds: Thresholds = Hard()
    if kind != "Hard":
        widths = Widths(**content["thresholds"]["widths"])
        thresholds = {"Soft": Soft, "StraightThrough": StraightThrough}[kind](
            content["thresholds"]["temperature"], widths
        )
    model = dataclasses.replace(model, thresholds=thresholds)
    free = Free(**{name: _choice(it) for name, it in content["free"].items()}, **_ties(content["ties"]))
    return Fit(
        model=model,
        observation=Observation(**content["observation"]),
        free=free,
        z=np.array(content["z"]),
        start={name: it["start"] for name, it in content["free"].items()},
        loss=content["loss"],
        soft_loss=content["soft_loss"],
        temperatures=tuple(content["temperatures"]),
        uncertainty=_uncertainty(free.names, content["uncertainty"]),
        curves=_read_curves(folder / "curves.csv"),
        runs=tuple(Run(**_tuples(run)) for run in content["runs"]),
        screened=tuple(content["screened"]),
        errors=content["errors"],
        result=content["result"],
        stats=content["stats"],
    )


def _choice(it: dict[str, Any]) -> Linear | Log:
    return {"linear": Linear, "log": Log}[it["scale"]](it["low"], it["high"], it["prior"] and tuple(it["prior"]))


def _ties(ties: dict[str, Any]) -> dict[str, Tie]:
    return {name: Tie(**tie) for name, tie in ties.items()}


def _thresholds(thresholds: Thresholds) -> dict[str, Any]:
    if not isinstance(thresholds, Soft | StraightThrough):
        return {"kind": "Hard"}
    widths = {field.name: float(getattr(thresholds.widths, field.name)) for field in dataclasses.fields(Widths)}
    return {"kind": type(thresholds).__name__, "temperature": float(thresholds.temperature), "widths": widths}


def _uncertainty(names: tuple[str, ...], content: dict[str, Any]) -> Uncertainty:
    def array(name: str, value):
        if not isinstance(value, list):
            return float("nan") if value is None else value
        beyond = math.inf if name == "standard_errors" else math.nan  # JSON has no word for either
        return np.array([[beyond if x is None else x for x in row] if isinstance(row, list) else
                         beyond if row is None else row for row in value])  # fmt: skip

    return Uncertainty(names=names, **{name: array(name, value) for name, value in content.items()})


def _tuples(run: dict[str, Any]) -> dict[str, Any]:
    return {name: tuple(it) if isinstance(it, list) else it for name, it in run.items()}


def _plain(value: Any) -> Any:
    """As JSON has it: arrays as lists, what is not finite as null."""
    if isinstance(value, dict):
        return {name: _plain(it) for name, it in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(it) for it in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _write_curves(path: Path, curves: tuple[Curve, ...]) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["condition", "channel", "time_ms", *_COLUMNS])
        for curve in curves:
            for row in zip(curve.time, *(getattr(curve, name) for name in _COLUMNS), strict=True):
                cells = ("" if math.isnan(value) else f"{value:.9g}" for value in row)
                writer.writerow([curve.condition, curve.channel, *cells])


def _read_curves(path: Path) -> tuple[Curve, ...]:
    """A curve ends where its name changes or time goes back."""
    curves: list[tuple[tuple[str, str], list[list[float]]]] = []
    with open(path, newline="", encoding="utf-8") as file:
        for condition, channel, *cells in list(csv.reader(file))[1:]:
            row = [float(cell) if cell else math.nan for cell in cells]
            if not curves or curves[-1][0] != (condition, channel) or row[0] <= curves[-1][1][-1][0]:
                curves.append(((condition, channel), []))
            curves[-1][1].append(row)
    return tuple(Curve(*name, *np.array(rows).T) for name, rows in curves)
