"""The sections of the report of a fit of alarms, and the table of its clips."""

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from lgmd2jax._network.parameters import ParameterSet, symbols
from lgmd2jax._reports.section import Section
from lgmd2jax.alarms._comparison import INTERVALS, Comparison, Outcome
from lgmd2jax.alarms._counts import Share
from lgmd2jax.alarms._detectors import TITLES
from lgmd2jax.alarms._evaluation import Evaluation, HeldOutScores, Verdict
from lgmd2jax.alarms._reasons import FalseAlarm, Miss
from lgmd2jax.alarms._starts import AlarmDescent
from lgmd2jax.fitting import Free

_WHY = (
    "Why: in a missed window the evidence was too weak (below T_sp), inhibited (in so many frames; without inhibition "
    "the alarm would have come) or late. Of a false alarm the share of the field above T_s in the five frames before "
    "it, and where it lay."
)
_LOW, _HIGH, _ALL_OVER = 0.4, 0.6, 0.5  # of the field
_MOST = 24  # clips with a row of their own; of more, those with the smallest margin


def headline(evaluation: Evaluation) -> str:
    """On how many clips the model is correct, in a line."""
    judged = [verdict for verdict in evaluation.verdicts() if not math.isnan(verdict.margin)]
    right = sum(verdict.right for verdict in judged)
    margin = min((verdict.margin for verdict in judged), default=math.nan)
    return f"correct on {right} of {len(judged)} clips" + (f", with a margin of {margin:.3f}" if margin > 0 else "")


def _windows(evaluation: Evaluation) -> str:
    return f"{evaluation.windows} window{'' if evaluation.windows == 1 else 's'}"


def _before_contact(milliseconds: Sequence[float]) -> str:
    """The shortest and the longest time, and the median; a single time where they are alike."""
    ordered = sorted(milliseconds)
    first, median, last = (f"{ordered[place]:.0f}" for place in (0, len(ordered) // 2, -1))
    return f"{first} ms before contact" if first == last else f"{first} to {last} ms before contact, median {median}"


def clip_section(evaluation: Evaluation, left_out: Mapping[str, int], title: str = "Clips") -> Section:
    """A row for each clip. `left_out`: errors on a clip of the fit without its source, by the clip's name.

    `title`: which clips these are.
    """
    verdicts, score = evaluation.verdicts(), evaluation.score()
    worst_first = sorted(verdicts, key=lambda verdict: (verdict.right, verdict.margin))
    rows = verdicts if len(verdicts) <= _MOST else worst_first[:_MOST]
    warnings = [verdict.warning_ms for verdict in verdicts if not math.isnan(verdict.warning_ms)]
    sentences = [
        f"The model is {headline(evaluation)}. It hits {_percent(score.hits)} of {_windows(evaluation)}, with "
        f"{_rate(score.false_alarms)} false alarms a minute in {evaluation.silent_minutes:.2f} minutes of silence.",
        "Margin: how far T_sp may change before the verdict does, in units of U'; negative where the model is wrong.",
    ]
    if any(verdict.misses or verdict.raised for verdict in verdicts):
        sentences.append(_WHY)
    if warnings:
        sentences.append(f"The first alarm in a window comes {_before_contact(warnings)}.")
    if not any(clip.silent for clip in evaluation.clips):
        sentences.append(
            "No clip has a silence, in which false alarms are counted: a model that always fires is correct."
        )
    columns = ("clip", "fps|", "alarms in frames", "before contact|", "margin|", "verdict", "why")
    columns += ("fit without its source",) if left_out else ()
    few = "" if len(rows) == len(verdicts) else f": the {_MOST} with the smallest margin, of {len(verdicts)}"
    table = tuple(_row(verdict, evaluation.T_sp, left_out) for verdict in rows)
    return Section(f"{title}{few}", columns, table, tuple(sentences))


def _row(verdict: Verdict, T_sp: float, left_out: Mapping[str, int]) -> tuple[str, ...]:
    alarms = ", ".join(f"{first}-{last}" for first, last in verdict.alarms) or "none"
    warning = "" if math.isnan(verdict.warning_ms) else f"{verdict.warning_ms:.0f} ms"
    missed = verdict.hits.count(False)
    wrong = [f"{missed} missed"] * bool(missed) + [f"{verdict.false_alarms} false"] * bool(verdict.false_alarms)
    judged = bool(verdict.hits) or not math.isnan(verdict.margin)
    row = (verdict.clip, f"{verdict.fps:.1f}", alarms, warning, f"{verdict.margin:+.3f}" if judged else "")
    row += (", ".join(wrong) or ("correct" if judged else "no labels"), why(verdict, T_sp))
    if not left_out:
        return row
    wrong_without = left_out.get(verdict.clip)
    return (*row, "" if wrong_without is None else "wrong" if wrong_without else "correct")


def why(verdict: Verdict, T_sp: float) -> str:
    """Why each window was missed, and where each false alarm came from; empty where the model is correct."""
    return "; ".join([*(_of_miss(miss, T_sp) for miss in verdict.misses), *map(_of_false_alarm, verdict.raised)])


def _of_miss(miss: Miss, T_sp: float) -> str:
    frames = f"{miss.window[0]}-{miss.window[1]}:"
    late = "" if math.isnan(miss.late_ms) else f"late by {miss.late_ms:.0f} ms"
    inhibited = f"inhibited in {miss.inhibited:.0%} of it" if miss.inhibited or miss.why == "inhibited" else ""
    weak = f"too weak, {miss.evidence:.3f} < {T_sp:.3f}" if miss.why == "weak" else ""
    return f"{frames} {', '.join(filter(None, (weak, inhibited, late)))}"


def _of_false_alarm(alarm: FalseAlarm) -> str:
    row = "upper " if alarm.row < _LOW else "lower " if alarm.row > _HIGH else ""
    col = "left" if alarm.col < _LOW else "right" if alarm.col > _HIGH else "middle"
    where = "all over" if alarm.field > _ALL_OVER else f"{row}{col}"
    return f"{alarm.frames[0]}-{alarm.frames[1]}: {alarm.field:.0%} of the field, {where}"


def comparison_section(title: str, comparison: Comparison) -> Section:
    """Detectors side by side, at their own thresholds and at budgets of false alarms."""
    rows = []
    for name, compared in comparison.detectors.items():
        shown = TITLES.get(name, name)
        if compared.own is not None:
            rows.append(_compared(shown, "its own", compared.own))
        rows += [_compared(shown, f"{budget:g} a minute", outcome) for budget, outcome in compared.at_budgets.items()]
    first = next(iter(comparison.detectors))
    first = TITLES.get(first, first)
    sentences = (
        'Threshold: the detector\'s own, or the lowest that keeps within a budget, as "1 a minute", of false alarms.',
        f"Thresholds for a budget were chosen on {comparison.training}.",
        f"The last column is the share of windows that the {first} hits less that of the detector, at the same budget.",
        f"In brackets: {INTERVALS}.",
    )
    columns = ("detector", "threshold", "windows hit", "false alarms a minute", f"{first} hits more")
    return Section(title, columns, tuple(rows), sentences)


def _compared(name: str, threshold: str, outcome: Outcome) -> tuple[str, ...]:
    score, more = outcome.counts.score(), outcome.more_hits
    hits = f"{outcome.counts.hits.sum()} of {outcome.counts.windows.sum()}"
    hits += f" ({score.hits.low:.0%} .. {score.hits.high:.0%})"
    ahead = "" if more is None or math.isnan(more.value) else f"{more.value:+.0%}"
    if ahead and more is not None and not math.isnan(more.low):
        ahead += f" ({more.low:+.0%} .. {more.high:+.0%})"
    return name, threshold, hits, _rate(score.false_alarms), ahead


def search_section(
    screened: int, right: int, descents: Sequence[AlarmDescent], left_out: Mapping[str, int], stopped: bool
) -> Section:
    """How many parameter sets are correct, what the descents gained, and how fits without a source do on its clips."""
    sentences = [
        f"{screened} parameter sets were drawn within the bounds, each with its best T_sp: "
        f"{right} ({right / screened:.2%}) are correct on all clips."
    ]
    for descent in descents:
        after = f"{descent.after:.3f}" + (f" (cost {descent.cost:g})" if descent.cost else "")
        sentences.append(f"Start {descent.start}: margin {descent.before:.3f} before the descent, {after} after it.")
    if left_out:
        kept = sum(not wrong for wrong in left_out.values())
        sentences.append(
            f"Each source was left out once: the fit to the others is correct on {kept} of the {len(left_out)} clips "
            "left out. These fits have no descent and a shorter search."
        )
    if stopped:
        sentences.append("Stopped by hand: this is the best result so far.")
    return Section("Search", sentences=tuple(sentences))


def held_out_section(held_out: HeldOutScores) -> Section:
    """The scores on held-out clips."""
    rows = tuple((name, _percent(score.hits), _rate(score.false_alarms)) for name, score in held_out.scores.items())
    return Section(
        f"Held-out clips: {held_out.windows} windows, {held_out.minutes:.1f} minutes of silence",
        ("model", "windows hit", "false alarms a minute"),
        rows,
        ("In brackets: 95 % intervals, Wilson's of the windows hit, Garwood's of the false alarms.",),
    )


def parameter_section(free: Free, parameters: ParameterSet, ranges: Mapping[str, tuple[float, float]]) -> Section:
    """The fitted values. `ranges`: between which values each lay in the sets that are correct on all clips."""
    known, rows = symbols(), []
    for name in free.names:
        low, high = ranges.get(name, (math.nan, math.nan))
        where = "" if math.isnan(low) else f"{low:.4g} .. {high:.4g}"
        unit = known[name].unit if known[name].unit != "1" else ""
        rows.append((name, f"{float(getattr(parameters, name)):.5g}", unit, where))
    for name, tie in free.ties.items():
        rows.append((name, f"{float(getattr(parameters, name)):.5g}", "", f"= {tie.factor:g} {tie.to}"))
    title = "Parameters" + (", and their ranges over the sets that are correct on all clips" if ranges else "")
    return Section(title, ("name", "value|", "unit", "range"), tuple(rows))


def _percent(share: Share) -> str:
    return "none" if math.isnan(share.value) else f"{share.value:.1%} ({share.low:.1%} .. {share.high:.1%})"


def _rate(rate: Share) -> str:
    return "-" if math.isnan(rate.value) else f"{rate.value:.2f} ({rate.low:.2f} .. {rate.high:.2f})"


def write_table(path: Path, evaluation: Evaluation) -> None:
    """A CSV file with a row for each clip."""
    rows = [["clip", "fps", "alarms", "windows", "hits", "false_alarms", "warning_ms", "margin", "right", "why"]]
    for verdict in evaluation.verdicts():
        numbers = ["" if math.isnan(value) else f"{value:.6g}" for value in (verdict.warning_ms, verdict.margin)]
        alarms = " ".join(f"{first}-{last}" for first, last in verdict.alarms)
        counts = [str(len(verdict.hits)), str(sum(verdict.hits)), str(verdict.false_alarms)]
        told = [str(int(verdict.right)), why(verdict, evaluation.T_sp)]
        rows.append([verdict.clip, f"{verdict.fps:.6g}", alarms, *counts, *numbers, *told])
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(rows)
