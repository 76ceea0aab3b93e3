"""What a fit of alarms says of itself, as text and as HTML."""

import csv
import dataclasses
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lgmd2jax._network.parameters import symbols
from lgmd2jax._reports.section import Section, as_html, as_text
from lgmd2jax.alarms._watch import Score, Share, Verdict, Watch

if TYPE_CHECKING:
    from lgmd2jax.alarms._result import AlarmFit

_MOST = 24  # clips that are told one by one; of more, the ones with the least margin


@dataclasses.dataclass(frozen=True)
class Held:
    """What models do on clips that the fit did not see, by what the model is called."""

    minutes: float
    windows: int
    scores: Mapping[str, Score]

    @classmethod
    def of(cls, watches: Mapping[str, Watch]) -> "Held":
        """From the watches of all models over the same clips."""
        first = next(iter(watches.values()))
        return cls(first.silent_minutes, first.windows, {name: it.score() for name, it in watches.items()})


def text(fit: "AlarmFit", held: Held | None = None) -> str:
    """The report, at most 110 columns wide."""
    return as_text(_sections(fit, held))


def html(fit: "AlarmFit", held: Held | None = None) -> str:
    """The same as HTML."""
    return as_html(_sections(fit, held))


def watched(watch: Watch) -> str:
    """What a model does on clips, as text."""
    return as_text([_clips(watch, {})])


def headline(watch: Watch) -> str:
    """In a line, how right the model is."""
    judged = [it for it in watch.verdicts() if not math.isnan(it.margin)]
    right = sum(it.right for it in judged)
    margin = min((it.margin for it in judged), default=math.nan)
    return f"right on {right} of {len(judged)} clips" + (f", by a margin of {margin:.3f}" if margin > 0 else "")


def _sections(fit: "AlarmFit", held: Held | None) -> list[Section]:
    sections = [_clips(fit.watch, fit.left_out), _found(fit), _parameters(fit)]
    if held is not None:
        sections.insert(1, _held(held))
    return sections


def _clips(watch: Watch, left_out: Mapping[str, int]) -> Section:
    verdicts, score = watch.verdicts(), watch.score()
    shown = verdicts if len(verdicts) <= _MOST else sorted(verdicts, key=lambda it: (it.right, it.margin))[:_MOST]
    warnings = [it.warning_ms for it in verdicts if not math.isnan(it.warning_ms)]
    sentences = [
        f"{headline(watch)}: of {watch.windows} windows hit {_percent(score.hits)}; "
        f"in {watch.silent_minutes:.2f} silent minutes {_rate(score.false_alarms)} false alarms a minute.",
        "A margin says how far T_sp may move, in units of the adapted potential, before the verdict changes.",
    ]
    if warnings:
        ordered = sorted(warnings)
        sentences.append(
            f"Time from the first alarm in a window to contact: {ordered[0]:.0f} to {ordered[-1]:.0f} ms, "
            f"median {ordered[len(ordered) // 2]:.0f}."
        )
    if not any(clip.silent for clip in watch.clips):
        sentences.append("No clip has a silence: nothing here speaks against a model that always fires.")
    columns = ("clip", "alarms in frames", "before contact|", "margin|", "verdict")
    columns += ("without this clip",) if left_out else ()
    few = "" if len(shown) == len(verdicts) else f": the {_MOST} of least margin of {len(verdicts)}"
    return Section(f"Clips{few}", columns, tuple(_row(it, left_out) for it in shown), tuple(sentences))


def _row(verdict: Verdict, left_out: Mapping[str, int]) -> tuple[str, ...]:
    alarms = ", ".join(f"{first}-{last}" for first, last in verdict.alarms) or "none"
    warning = "" if math.isnan(verdict.warning_ms) else f"{verdict.warning_ms:.0f} ms"
    missed = verdict.hits.count(False)
    wrong = [f"{missed} missed"] * bool(missed) + [f"{verdict.false_alarms} false"] * bool(verdict.false_alarms)
    judged = bool(verdict.hits) or not math.isnan(verdict.margin)
    row = (verdict.clip, alarms, warning, f"{verdict.margin:+.3f}" if judged else "")
    row += (", ".join(wrong) or ("right" if judged else "not judged"),)
    if not left_out:
        return row
    wrong_without = left_out.get(verdict.clip)
    return (*row, "" if wrong_without is None else "wrong" if wrong_without else "right")


def _found(fit: "AlarmFit") -> Section:
    sentences = [
        f"Of {fit.screened} parameter sets anywhere within the bounds {fit.right} ({fit.right / fit.screened:.2%}) are "
        "right on all clips, each with the T_sp that suits it best."
    ]
    for it in fit.descended:
        after = f"{it.after:.3f}" + (f" at a cost of {it.cost:g}" if it.cost else "")
        sentences.append(f"Start {it.start}: margin {it.before:.3f} by search, {after} after the descent.")
    if fit.left_out:
        kept = sum(not wrong for wrong in fit.left_out.values())
        sentences.append(
            f"Chosen anew without a clip, among the same sets, the best is right on that clip {kept} times of "
            f"{len(fit.left_out)}."
        )
    if fit.stopped:
        sentences.append("Stopped by hand: this is the best so far.")
    return Section("How it was found", sentences=tuple(sentences))


def _held(held: Held) -> Section:
    rows = tuple((name, _percent(it.hits), _rate(it.false_alarms)) for name, it in held.scores.items())
    return Section(
        f"Clips that the fit did not see: {held.windows} windows, {held.minutes:.1f} silent minutes",
        ("model", "windows hit", "false alarms a minute"),
        rows,
        ("In brackets 95 % intervals: Wilson's of a share, Garwood's of a count.",),
    )


def _parameters(fit: "AlarmFit") -> Section:
    known, rows = symbols(), []
    for name in fit.free.names:
        low, high = fit.ranges.get(name, (math.nan, math.nan))
        where = "" if math.isnan(low) else f"{low:.4g} .. {high:.4g}"
        value = float(getattr(fit.model.parameters, name))
        rows.append((name, f"{value:.5g}", known[name].unit if known[name].unit != "1" else "", where))
    for name, tie in fit.free.ties.items():
        rows.append((name, f"{float(getattr(fit.model.parameters, name)):.5g}", "", f"= {tie.factor:g} {tie.to}"))
    title = "Parameters, and where they lie in the sets that are right on all clips"
    return Section(title, ("name", "value|", "unit", "right sets"), tuple(rows))


def _percent(share: Share) -> str:
    return "none" if math.isnan(share.value) else f"{share.value:.1%} ({share.low:.1%} .. {share.high:.1%})"


def _rate(rate: Share) -> str:
    return "-" if math.isnan(rate.value) else f"{rate.value:.2f} ({rate.low:.2f} .. {rate.high:.2f})"


def write_table(path: Path, verdicts: Sequence[Verdict]) -> None:
    """A CSV file with a row for each clip."""
    rows = [["clip", "alarms", "windows", "hits", "false_alarms", "warning_ms", "margin", "right"]]
    for it in verdicts:
        numbers = ["" if math.isnan(value) else f"{value:.6g}" for value in (it.warning_ms, it.margin)]
        alarms = " ".join(f"{first}-{last}" for first, last in it.alarms)
        counts = [str(len(it.hits)), str(sum(it.hits)), str(it.false_alarms)]
        rows.append([it.clip, alarms, *counts, *numbers, str(int(it.right))])
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(rows)
