"""The results of a fit as a folder, and back."""

import csv
import dataclasses
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lgmd2jax._arguments.checked import checked
from lgmd2jax._channels import Channel
from lgmd2jax._files.atomic import read_json
from lgmd2jax._files.catalogue import locate
from lgmd2jax._files.lock import locked
from lgmd2jax._handover.model_file import load, save
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._results.fit_data import DATA, entry_of, holds, source_of_data, write_data
from lgmd2jax._results.fit_json import content_of, fit_of, plain
from lgmd2jax._results.posterior_nc import write_posterior
from lgmd2jax._results.results_folder import (
    ALARM_FIT,
    FIGURES,
    MARKER,
    SEARCH,
    Documents,
    ResultsFolder,
    warn_if_unfinished,
)
from lgmd2jax._schemas.check import check
from lgmd2jax._schemas.fit import FIT, ROWS
from lgmd2jax._targets.observation import Observation
from lgmd2jax._words import warn_renamed, within
from lgmd2jax.fitting import Curve, Fit, Posterior, Supplement
from lgmd2jax.fitting._conditions import AnyCondition
from lgmd2jax.fitting._curve import rest_of
from lgmd2jax.fitting._problem import Problem
from lgmd2jax.fitting._search.descent import STOPPED

_FIGURES = ("fit.png", "diagnostics.png")
_POSTERIOR = "posterior.nc"
_FILES = ("model.json", "curves.csv", DATA, _POSTERIOR)
_STATISTICS = ("energy", "diverging", "acceptance_rate", "tree_depth")
_FURTHER = ("upper", "exposure")  # columns that only some curves have
_COLUMNS = ("target", "sem", "weight", "soft", "hard", "band", "error")


@checked
def save_fit(
    fit: Fit,
    folder: str | Path,
    *,
    name: str | None = None,
    extra: Supplement | None = None,
    provenance: dict[str, Any] | None = None,
    notes: dict[str, Any] | None = None,
    draws: Posterior | None = None,
    made: dict[str, Any] | None = None,
) -> None:
    """Write a fit's folder: model.json, fit.json, curves.csv, fit.png, diagnostics.png, report.txt and report.html.

    The folder appears whole; an old one of results is replaced in one step, and what else stands in it is kept. The
    figures follow in a second step, until which the report calls them unfinished. A fit that was stopped by hand is
    marked as unfinished, in the model too.

    **Arguments:** `name`: of the report, by default the folder's. `extra`: further sections of the report.
    `provenance`: plain values for model.json, which equal fits share. `notes`: what else fit.json is to say.
    `draws`: of the posterior, for posterior.nc. `made`: the old name of `notes`.

    **Raises:** `ValueError` for a folder that holds something else, that another process works on, or that cannot be
    written.
    """
    if made is not None:
        warn_renamed("save_fit(made=...)", "save_fit(notes=...)")
        notes = made
    extra, provenance = extra or Supplement(), provenance or {}
    if fit.result == STOPPED:
        extra = dataclasses.replace(extra, unfinished=(SEARCH, *extra.unfinished))
        provenance = {**provenance, "unfinished": SEARCH}
    with locked(folder):
        results = FitFolder(fit, Path(folder), name or Path(folder).absolute().name, notes or {})
        results.begin(extra, provenance, draws)
        results.draw(extra)


@dataclasses.dataclass(frozen=True)
class FitFolder:
    """A fit's folder, written step by step; what a supplement calls unfinished is marked as such.

    `notes`: what else fit.json is to say.
    """

    fit: Fit
    path: Path
    name: str
    notes: Mapping[str, Any]

    def begin(self, extra: Supplement, provenance: Mapping[str, Any], draws: Posterior | None = None) -> None:
        """Put the fit, without figures, in the place of what is there."""

        def write(folder: Path) -> None:
            save(self.fit.model, folder / "model.json", provenance=provenance)
            _write_curves(folder / "curves.csv", self.fit.curves)
            if self._held is not None:
                write_data(folder / DATA, self._held)
            if draws is not None:
                self._write_draws(folder, draws)

        without = dataclasses.replace(extra, unfinished=(FIGURES, *extra.unfinished))
        self._folder.begin(self._documents(without), write)

    def draw(self, extra: Supplement) -> None:
        """Add the figures."""
        from lgmd2jax._figures.fit import diagnostics_figure, fit_figure  # the only part that needs matplotlib

        def draw(folder: Path) -> None:
            fit_figure(folder / _FIGURES[0], self.fit.curves, self.name)
            diagnostics_figure(folder / _FIGURES[1], self.fit)

        self._folder.draw(self._documents(extra), draw)

    def add(self, extra: Supplement) -> None:
        """Add what a supplement says."""
        self._folder.add(self._documents(extra))

    def add_draws(self, extra: Supplement, draws: Posterior) -> None:
        """Add draws of the posterior."""
        self._folder.add(self._documents(extra), lambda folder: self._write_draws(folder, draws), (_POSTERIOR,))

    @property
    def _folder(self) -> ResultsFolder:
        return ResultsFolder(self.path, f"Fit {self.name}", _FIGURES, _FILES)

    @property
    def _held(self) -> Problem | None:
        """The data that the folder is to hold: those that the notes do not name."""
        return self.fit.problem if "data" not in self.notes and holds(self.fit.problem) else None

    def _documents(self, extra: Supplement) -> Documents:
        content = {"name": self.name} | content_of(self.fit, extra) | plain(dict(self.notes))
        if self._held is not None:
            content["data"] = entry_of(self._held)
        return Documents(content, self.fit.sections(extra))

    def _write_draws(self, folder: Path, draws: Posterior) -> None:
        units = {parameter.name: parameter.symbol.unit for parameter in self.fit.free.parameters}
        statistics = {name: np.asarray(getattr(draws, name)) for name in _STATISTICS}
        write_posterior(folder / _POSTERIOR, self.fit.values_of(draws), units, statistics)


@checked
def load_fit(
    folder: str | Path,
    conditions: Sequence[AnyCondition] | None = None,
    *,
    network: type[AbstractNetwork] | None = None,
) -> Fit:
    """The fit of a result folder or of its fit.json, or of a shipped one by its bare name.

    It predicts, compares and plots by itself. What needs stimuli and targets, as profiles and draws do, takes those
    that the folder holds, or renders the protocol that it names, and refuses where they are not those of the fit.

    **Arguments:** `conditions`: in their place, as for `fit`; they must be the same. `network`: the class of a network
    of your own.

    An `UnfinishedWarning` says what is still to come of a fit that was stopped.

    **Raises:** `ValueError` for a folder that holds no fit, `FileNotFoundError` where there is none.
    """
    return load_validated_fit(folder, conditions, network)[0]


def load_validated_fit(
    folder: str | Path,
    conditions: Sequence[AnyCondition] | None = None,
    network: type[AbstractNetwork] | None = None,
) -> tuple[Fit, dict[str, float]]:
    """The fit of `load_fit`, and R2 of each condition that was left out, predicted by a fit to others; {} for none."""
    folder = fit_folder(folder)
    content = read_json(folder / MARKER)
    if isinstance(content, dict) and content.get("format") == ALARM_FIT:
        model = folder / "model.json"
        raise ValueError(
            f"{folder} holds a fit to labelled clips, and not one to curves; its model is {model}, which "
            f"lgmd2jax.load({str(model)!r}) reads, and --model {folder} in other commands"
        )
    with within(f"{folder} holds no fit that can be used"):
        with within(MARKER):
            check(FIT, content)
        with within("curves.csv"):
            curves = _read_curves(folder / "curves.csv", Observation(**content["observation"]))
        fit = fit_of(content, load(folder / "model.json", network), curves)
        fit = dataclasses.replace(fit, data=source_of_data(folder, content, conditions))
    warn_if_unfinished(folder, content.get("unfinished", ()))  # an earlier version did not write it
    return fit, {name: math.nan if r2 is None else r2 for name, r2 in content["leave_one_out_r2"].items()}


def fit_folder(folder: str | Path) -> Path:
    """The folder of a fit that a path or a bare name stands for.

    **Raises:** `ValueError` for a folder that holds no fit, `FileNotFoundError` where there is none.
    """
    path = Path(folder)
    if path.is_file():
        if path.name != MARKER:
            raise ValueError(f"{path} is a file; give the folder of a fit, which holds a {MARKER}")
        return path.parent
    if path.is_dir():
        if not (path / MARKER).is_file():
            raise ValueError(f"{path} holds no fit: there is no {MARKER}")
        return path
    return locate(folder, "fits", f"/{MARKER}").parent


def _write_curves(path: Path, curves: tuple[Curve, ...]) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        further = [name for name in _FURTHER if any(getattr(curve, name) is not None for curve in curves)]
        writer.writerow(["condition", "channel", "time_ms", *_COLUMNS, *further])
        for curve in curves:
            columns = [getattr(curve, name) for name in _COLUMNS]
            for name in further:
                values = getattr(curve, name)
                columns.append(np.full(len(curve.time), np.nan) if values is None else values)
            for row in zip(curve.time, *columns, strict=True):
                cells = ("" if math.isnan(value) else f"{value:.9g}" for value in row)
                writer.writerow([curve.condition, curve.channel, *cells])


def _read_curves(path: Path, observation: Observation) -> tuple[Curve, ...]:
    """A curve ends where its name changes or time goes back."""
    rows = _rows(path)
    check(ROWS, rows)
    curves: list[tuple[tuple[str, Channel], list[dict[str, Any]]]] = []
    for row in rows:
        name, time = (row.pop("condition"), row.pop("channel")), row["time_ms"]
        if not curves or curves[-1][0] != name or time <= curves[-1][1][-1]["time_ms"]:
            curves.append((name, []))
        curves[-1][1].append(row)
    return tuple(_curve(*name, rest_of(name[1], observation), rows) for name, rows in curves)


def _rows(path: Path) -> list[dict[str, Any]]:
    """The rows of a table by the names in its header; cells that hold numbers as numbers, empty ones as None."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            header, *lines = list(csv.reader(file, strict=True)) or [[]]
    except (csv.Error, UnicodeDecodeError) as error:
        raise ValueError(f"it is no table of comma-separated values: {error}") from error
    if len(set(header)) < len(header):
        raise ValueError(f"its header names a column twice: {','.join(header):.80}")
    for number, cells in enumerate(lines):
        if len(cells) != len(header):
            raise ValueError(f"[{number}] has {len(cells)} cells and the header {len(header)}")
    return [{name: _cell(name, text) for name, text in zip(header, cells, strict=True)} for cells in lines]


def _cell(name: str, text: str) -> Any:
    if name in ("condition", "channel"):
        return text
    try:
        return float(text) if text else None
    except ValueError:
        return text  # which the schema refuses


def _curve(condition: str, channel: Channel, rest: float, rows: list[dict[str, Any]]) -> Curve:
    """The curve. Columns that only some curves have are empty beside others; an earlier version wrote no errors."""
    columns: dict[str, Any] = {
        name: np.array([math.nan if (value := row.get(name)) is None else value for row in rows])
        for name in ("time_ms", *_COLUMNS, *_FURTHER)
    }
    further: dict[str, Any] = {
        name: None if np.isnan(column := columns.pop(name)).all() else column for name in _FURTHER
    }
    return Curve(condition, channel, columns.pop("time_ms"), **columns, **further, rest=rest)
