"""The results of a fit of alarms as a folder."""

import json
from pathlib import Path
from typing import Any

from lgmd2jax._files.folder import replaced_folder
from lgmd2jax._handover.model_file import save
from lgmd2jax._reports.page import report_page
from lgmd2jax._results.fit_folder import MARKER, OWN
from lgmd2jax._results.fit_json import plain
from lgmd2jax.alarms import AlarmFit, Held, Score
from lgmd2jax.alarms._report import html, write_table
from lgmd2jax.fitting._descent import STOPPED

_FORMAT, _VERSION = "lgmd2jax-alarm-fit", 1


def save_alarm_fit(
    fit: AlarmFit, folder: Path, *, name: str, held: Held | None, provenance: dict[str, Any], made: dict[str, Any]
) -> None:
    """Write model.json, fit.json, clips.csv, fit.png, diagnostics.png, worst.png, report.txt and report.html.

    The folder appears whole, or stays as it was.

    **Raises:** `ValueError` for a folder that holds something else, or that cannot be written.
    """
    from lgmd2jax._figures.alarms import clips_figure, operating_figure, worst_figure  # these need matplotlib

    pictures = ("fit.png", "diagnostics.png", "worst.png")
    with replaced_folder(folder, MARKER, (*OWN, "clips.csv", "worst.png")) as new:
        save(fit.model, new / "model.json", provenance=provenance)
        content = {"format": _FORMAT, "version": _VERSION, "name": name, **plain(_content(fit, held)), **plain(made)}
        (new / MARKER).write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        write_table(new / "clips.csv", fit.watch.verdicts())
        clips_figure(new / pictures[0], fit.watch, name)
        operating_figure(new / pictures[1], fit.watch)
        worst_figure(new / pictures[2], fit.watch)
        (new / "report.txt").write_text(fit.summary(held) + "\n", encoding="utf-8")
        page = report_page(f"Alarms {name}", [new / it for it in pictures], html(fit, held))
        (new / "report.html").write_text(page, encoding="utf-8")


def _content(fit: AlarmFit, held: Held | None) -> dict[str, Any]:
    return {
        "free": {it.name: {"low": it.low, "high": it.high, "scale": it.scale} for it in fit.free.freedoms},
        "values": {name: float(getattr(fit.model.parameters, name)) for name in fit.free.names},
        "z": fit.z,
        "cost": fit.cost,
        "margin": fit.margin,
        "screened": fit.screened,
        "right": fit.right,
        "ranges": fit.ranges,
        "descended": [it._asdict() for it in fit.descended],
        "left_out": fit.left_out,
        "score": _shares(fit.watch.score()),
        "held_out": None
        if held is None
        else {
            "windows": held.windows,
            "silent_minutes": held.minutes,
            "scores": {name: _shares(it) for name, it in held.scores.items()},
        },
        "result": STOPPED if fit.stopped else "descended" if fit.descended else "searched",
    }


def _shares(score: Score) -> dict[str, Any]:
    return {"hits": score.hits._asdict(), "false_alarms": score.false_alarms._asdict()}
