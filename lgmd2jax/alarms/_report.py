"""The sections of the report of a fit of alarms, and the table of its clips."""

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from lgmd2jax._network.parameters import ParameterSet, symbols
from lgmd2jax._reports.section import Section
from lgmd2jax.alarms._comparison import INTERVALS, Comparison, Outcome
from lgmd2jax.alarms._counts import Share
from lgmd2jax.alarms._detectors import WORDS
from lgmd2jax.alarms._evaluation import Evaluation, HeldOutScores, Verdict
from lgmd2jax.alarms._reasons import FalseAlarm, Miss
from lgmd2jax.alarms._starts import AlarmDescent
from lgmd2jax.fitting import Free

_WHY = (
    "Why a window was missed: inhibition shut where the excitation alone would have done, else too weak, or late. What "
    "drove a false alarm: the part of the field that passed T_s in the five frames before."
)
_LOW, _HIGH, _ALL_OVER = 0.4, 0.6, 0.5  # of the field
_MOST = 24  # clips that are told one by one; of more, the ones with the least margin


def headline(evaluation: Evaluation) -> str:
    """In a line, how right the model is."""
    judged = [verdict for verdict in evaluation.verdicts() if not math.isnan(verdict.margin)]
    right = sum(verdict.right for verdict in judged)
    margin = min((verdict.margin for verdict in judged), default=math.nan)
    return f"right on {right} of {len(judged)} clips" + (f", by a margin of {margin:.3f}" if margin > 0 else "")


def clip_section(evaluation: Evaluation, left_out: Mapping[str, int]) -> Section:
    """A row for each clip. `left_out`: what a set chosen without a clip gets wrong on it, by the clip's name."""
    verdicts, score = evaluation.verdicts(), evaluation.score()
    worst_first = sorted(verdicts, key=lambda verdict: (verdict.right, verdict.margin))
    rows = verdicts if len(verdicts) <= _MOST else worst_first[:_MOST]
    warnings = [verdict.warning_ms for verdict in verdicts if not math.isnan(verdict.warning_ms)]
    sentences = [
        f"{headline(evaluation)}; windows hit: {_percent(score.hits)} of {evaluation.windows}; "
        f"false alarms a minute: {_rate(score.false_alarms)}, in {evaluation.silent_minutes:.2f} silent minutes.",
        "A margin says how far T_sp may move, in units of the adapted potential, before the verdict changes.",
    ]
    if any(verdict.misses or verdict.raised for verdict in verdicts):
        sentences.append(_WHY)
    if warnings:
        ordered = sorted(warnings)
        sentences.append(
            f"Time from the first alarm in a window to contact: {ordered[0]:.0f} to {ordered[-1]:.0f} ms, "
            f"median {ordered[len(ordered) // 2]:.0f}."
        )
    if not any(clip.silent for clip in evaluation.clips):
        sentences.append("No clip has a silence: nothing here speaks against a model that always fires.")
    columns = ("clip", "fps|", "alarms in frames", "before contact|", "margin|", "verdict", "why")
    columns += ("without its source",) if left_out else ()
    few = "" if len(rows) == len(verdicts) else f": the {_MOST} of least margin of {len(verdicts)}"
    table = tuple(_row(verdict, evaluation.T_sp, left_out) for verdict in rows)
    return Section(f"Clips{few}", columns, table, tuple(sentences))


def _row(verdict: Verdict, T_sp: float, left_out: Mapping[str, int]) -> tuple[str, ...]:
    alarms = ", ".join(f"{first}-{last}" for first, last in verdict.alarms) or "none"
    warning = "" if math.isnan(verdict.warning_ms) else f"{verdict.warning_ms:.0f} ms"
    missed = verdict.hits.count(False)
    wrong = [f"{missed} missed"] * bool(missed) + [f"{verdict.false_alarms} false"] * bool(verdict.false_alarms)
    judged = bool(verdict.hits) or not math.isnan(verdict.margin)
    row = (verdict.clip, f"{verdict.fps:.1f}", alarms, warning, f"{verdict.margin:+.3f}" if judged else "")
    row += (", ".join(wrong) or ("right" if judged else "not judged"), why(verdict, T_sp))
    if not left_out:
        return row
    wrong_without = left_out.get(verdict.clip)
    return (*row, "" if wrong_without is None else "wrong" if wrong_without else "right")


def why(verdict: Verdict, T_sp: float) -> str:
    """Why each window was missed, and what drove each false alarm; nothing where all is right."""
    return "; ".join([*(_of_miss(miss, T_sp) for miss in verdict.misses), *map(_of_false_alarm, verdict.raised)])


def _of_miss(miss: Miss, T_sp: float) -> str:
    frames = f"{miss.window[0]}-{miss.window[1]}:"
    late = "" if math.isnan(miss.late_ms) else f"late by {miss.late_ms:.0f} ms"
    shut = f"inhibition shut {miss.inhibited:.0%} of it" if miss.inhibited or miss.why == "inhibited" else ""
    weak = f"too weak, {miss.evidence:.3f} of {T_sp:.3f}" if miss.why == "weak" else ""
    return f"{frames} {', '.join(filter(None, (weak, shut, late)))}"


def _of_false_alarm(alarm: FalseAlarm) -> str:
    row = "upper " if alarm.row < _LOW else "lower " if alarm.row > _HIGH else ""
    col = "left" if alarm.col < _LOW else "right" if alarm.col > _HIGH else "middle"
    where = "all over" if alarm.field > _ALL_OVER else f"{row}{col}"
    return f"{alarm.frames[0]}-{alarm.frames[1]}: {alarm.field:.0%} of the field, {where}"


def comparison_section(title: str, comparison: Comparison) -> Section:
    """Detectors side by side, at their own thresholds and at budgets of false alarms."""
    rows = []
    for name, compared in comparison.detectors.items():
        words = WORDS.get(name, name)
        if compared.own is not None:
            rows.append(_compared(words, "its own", compared.own))
        rows += [_compared(words, f"{budget:g} a minute", outcome) for budget, outcome in compared.at_budgets.items()]
    first = next(iter(comparison.detectors))
    sentences = (
        f"Thresholds that keep within a budget of false alarms: {comparison.training}.",
        f"Ahead: how much larger a share of the windows the {WORDS.get(first, first)} hits at the same budget.",
        f"In brackets intervals, {INTERVALS}.",
    )
    columns = ("detector", "threshold", "windows hit", "false alarms a minute", "ahead by")
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
    """How many parameter sets are right, what descending brought, and how the choice does without a clip."""
    sentences = [
        f"Of {screened} parameter sets anywhere within the bounds {right} ({right / screened:.2%}) are right on all "
        "clips, each with the T_sp that suits it best."
    ]
    for descent in descents:
        after = f"{descent.after:.3f}" + (f" at a cost of {descent.cost:g}" if descent.cost else "")
        sentences.append(f"Start {descent.start}: margin {descent.before:.3f} by search, {after} after the descent.")
    if left_out:
        kept = sum(not wrong for wrong in left_out.values())
        sentences.append(
            f"Searched and chosen without a clip and the others of its source, the best set is right on that clip "
            f"{kept} times of {len(left_out)}. Each such search looks at the sets anywhere and at a few near the best "
            "of these, so less far than the fit."
        )
    if stopped:
        sentences.append("Stopped by hand: this is the best so far.")
    return Section("How it was found", sentences=tuple(sentences))


def held_out_section(held_out: HeldOutScores) -> Section:
    """The scores on clips that the fit did not see."""
    rows = tuple((name, _percent(score.hits), _rate(score.false_alarms)) for name, score in held_out.scores.items())
    return Section(
        f"Clips that the fit did not see: {held_out.windows} windows, {held_out.minutes:.1f} silent minutes",
        ("model", "windows hit", "false alarms a minute"),
        rows,
        ("In brackets 95 % intervals: Wilson's of a share, Garwood's of a count.",),
    )


def parameter_section(free: Free, parameters: ParameterSet, ranges: Mapping[str, tuple[float, float]]) -> Section:
    """The fitted values. `ranges`: between which values each lay in the sets that are right on all clips."""
    known, rows = symbols(), []
    for name in free.names:
        low, high = ranges.get(name, (math.nan, math.nan))
        where = "" if math.isnan(low) else f"{low:.4g} .. {high:.4g}"
        unit = known[name].unit if known[name].unit != "1" else ""
        rows.append((name, f"{float(getattr(parameters, name)):.5g}", unit, where))
    for name, tie in free.ties.items():
        rows.append((name, f"{float(getattr(parameters, name)):.5g}", "", f"= {tie.factor:g} {tie.to}"))
    title = "Parameters, and where they lie in the sets that are right on all clips"
    return Section(title, ("name", "value|", "unit", "right sets"), tuple(rows))


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
