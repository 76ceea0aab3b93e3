"""The results of a fit of alarms as a folder."""

import json
from pathlib import Path
from typing import Any

from lgmd2jax._files.folder import replaced_folder
from lgmd2jax._handover.model_file import save
from lgmd2jax._reports.page import report_page
from lgmd2jax._reports.section import as_html
from lgmd2jax._results.fit_folder import MARKER, OWN
from lgmd2jax._results.fit_json import plain
from lgmd2jax.alarms import AlarmFit, HeldOutScores, Score
from lgmd2jax.alarms._report import write_table
from lgmd2jax.fitting._search.descent import STOPPED

_FORMAT, _VERSION = "lgmd2jax-alarm-fit", 1


def save_alarm_fit(
    fit: AlarmFit,
    folder: Path,
    *,
    name: str,
    held_out: HeldOutScores | None,
    provenance: dict[str, Any],
    notes: dict[str, Any],
) -> None:
    """Write model.json, fit.json, clips.csv, fit.png, diagnostics.png, worst.png, report.txt and report.html.

    The folder appears whole, or stays as it was.

    **Arguments:** `notes`: what else fit.json is to say.

    **Raises:** `ValueError` for a folder that holds something else, or that cannot be written.
    """
    from lgmd2jax._figures.alarms import clips_figure, operating_figure, worst_figure  # these need matplotlib

    pictures = ("fit.png", "diagnostics.png", "worst.png")
    with replaced_folder(folder, MARKER, (*OWN, "clips.csv", "worst.png")) as new:
        save(fit.model, new / "model.json", provenance=provenance)
        content = {
            "format": _FORMAT,
            "version": _VERSION,
            "name": name,
            **plain(_content(fit, held_out)),
            **plain(notes),
        }
        (new / MARKER).write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        write_table(new / "clips.csv", fit.evaluation.verdicts())
        clips_figure(new / pictures[0], fit.evaluation, name)
        operating_figure(new / pictures[1], fit.evaluation)
        worst_figure(new / pictures[2], fit.evaluation)
        (new / "report.txt").write_text(fit.summary(held_out) + "\n", encoding="utf-8")
        page = report_page(f"Alarms {name}", [new / picture for picture in pictures], as_html(fit.sections(held_out)))
        (new / "report.html").write_text(page, encoding="utf-8")


def _content(fit: AlarmFit, held_out: HeldOutScores | None) -> dict[str, Any]:
    return {
        "free": {
            freedom.name: {"low": freedom.low, "high": freedom.high, "scale": freedom.scale}
            for freedom in fit.free.freedoms
        },
        "values": {name: float(getattr(fit.model.parameters, name)) for name in fit.free.names},
        "z": fit.z,
        "cost": fit.cost,
        "margin": fit.margin,
        "screened": fit.screened,
        "right": fit.right,
        "ranges": fit.ranges,
        "descended": [descent._asdict() for descent in fit.descended],
        "left_out": fit.left_out,
        "score": _shares(fit.evaluation.score()),
        "held_out": None
        if held_out is None
        else {
            "windows": held_out.windows,
            "silent_minutes": held_out.minutes,
            "scores": {name: _shares(score) for name, score in held_out.scores.items()},
        },
        "result": STOPPED if fit.stopped else "descended" if fit.descended else "searched",
    }


def _shares(score: Score) -> dict[str, Any]:
    return {"hits": score.hits._asdict(), "false_alarms": score.false_alarms._asdict()}
