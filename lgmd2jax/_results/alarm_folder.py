"""The results of a fit of alarms as a folder."""

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lgmd2jax._handover.model_file import save
from lgmd2jax._results.fit_json import plain
from lgmd2jax._results.results_folder import ALARM_FIT, FIGURES, Documents, ResultsFolder
from lgmd2jax._results.urgency import URGENCY_FILES
from lgmd2jax.alarms import AlarmFit, Comparison, HeldOutScores, Score
from lgmd2jax.alarms._report import write_table
from lgmd2jax.fitting._search.descent import STOPPED

_VERSION = 1
_FIGURES = ("fit.png", "diagnostics.png", "worst.png")


@dataclasses.dataclass(frozen=True)
class AlarmFolder:
    """The folder of a fit of alarms, written step by step; what is `unfinished` is marked as such.

    `notes`: what else fit.json is to say.
    """

    fit: AlarmFit
    path: Path
    name: str
    notes: Mapping[str, Any]

    def begin(self, unfinished: Sequence[str], provenance: Mapping[str, Any]) -> None:
        """Put the fit, without figures, in the place of what is there.

        **Raises:** `ValueError` for a folder that holds something else, or that cannot be written.
        """

        def write(folder: Path) -> None:
            save(self.fit.model, folder / "model.json", provenance=provenance)
            write_table(folder / "clips.csv", self.fit.evaluation)

        self._folder.begin(self._documents((FIGURES, *unfinished)), write)

    def draw(self, unfinished: Sequence[str]) -> None:
        """Add the figures."""
        from lgmd2jax._figures.alarms import clips_figure, operating_figure, worst_figure  # these need matplotlib

        def draw(folder: Path) -> None:
            clips_figure(folder / _FIGURES[0], self.fit.evaluation, f"{self.name}, fitted clips")
            operating_figure(folder / _FIGURES[1], self.fit.evaluation)
            worst_figure(folder / _FIGURES[2], self.fit.evaluation)

        self._folder.draw(self._documents(unfinished), draw)

    def add(
        self, unfinished: Sequence[str], held_out: HeldOutScores | None, comparisons: Mapping[str, Comparison]
    ) -> None:
        """Add what models do on held-out clips, and the comparisons with plain detectors, by title."""
        self._folder.add(self._documents(unfinished, held_out, comparisons))

    @property
    def _folder(self) -> ResultsFolder:
        return ResultsFolder(self.path, f"Alarms {self.name}", _FIGURES, ("model.json", "clips.csv", *URGENCY_FILES))

    def _documents(
        self,
        unfinished: Sequence[str],
        held_out: HeldOutScores | None = None,
        comparisons: Mapping[str, Comparison] | None = None,
    ) -> Documents:
        content = {
            "format": ALARM_FIT,
            "version": _VERSION,
            "name": self.name,
            "unfinished": list(unfinished),
            **plain(_content(self.fit, held_out)),
            "comparisons": plain({title: each.content() for title, each in (comparisons or {}).items()}),
            **plain(dict(self.notes)),
        }
        return Documents(content, self.fit.sections(held_out, unfinished, comparisons))


def _content(fit: AlarmFit, held_out: HeldOutScores | None) -> dict[str, Any]:
    return {
        "free": {
            parameter.name: {"low": parameter.low, "high": parameter.high, "scale": parameter.scale}
            for parameter in fit.free.parameters
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
