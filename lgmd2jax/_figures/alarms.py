"""The figures of a fit of alarms: clips as timelines, hits against false alarms, and the worst clips."""

import os

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from lgmd2jax._figures.style import BLACK, BLUE, COLOURS, GREEN, GREY, MARKS, VERMILION, drawn
from lgmd2jax._signals import stretches
from lgmd2jax.alarms import ClipLabels, Comparison, Evaluation, LabelledClip, Reliability, Score, Verdict
from lgmd2jax.alarms._detectors import TITLES
from lgmd2jax.alarms._report import headline

_LINES = 30  # clips at most
_WORST, _PICTURES = 4, 5
_STEPS = 200


def clips_figure(path: str | os.PathLike, evaluation: Evaluation, name: str) -> None:
    """A line for each clip, smallest margin first: where an alarm is wanted, where silence, and where it was raised."""
    rows = _by_margin(evaluation)[:_LINES]
    with drawn(path, 9, 1.4 + 0.24 * len(rows)) as figure:
        axes = figure.subplots()
        for y, (clip, trace, verdict) in enumerate(rows):
            on = trace >= evaluation.T_sp
            _bars(axes, clip, clip.in_silence(), y, GREY, 0.35, 0.6)
            for inside in clip.in_windows():
                _bars(axes, clip, inside, y, GREEN, 0.45, 0.6)
            for first, last in stretches(on):
                good = clip.in_windows()[:, first : last + 1].any() or not clip.in_silence()[first : last + 1].any()
                axes.plot(
                    clip.time[[first, last]] / 1000,
                    [y, y],
                    color=BLACK if good else VERMILION,
                    linewidth=4,
                    solid_capstyle="butt",
                )
                axes.plot(clip.time[first] / 1000, y, "|", color=BLACK if good else VERMILION, markersize=8)
            if clip.contact_ms is not None:
                axes.plot(clip.contact_ms / 1000, y, "x", color=BLUE, markersize=6)
            if not verdict.right:
                axes.annotate(
                    "wrong", (1.005, y), xycoords=("axes fraction", "data"), va="center", color=VERMILION, fontsize=8
                )
        axes.set_yticks(range(len(rows)), [clip.name for clip, _, _ in rows])
        axes.set(xlabel="time (s)", ylim=(len(rows) - 0.4, -0.6), xlim=(0, None))
        axes.grid(False)
        axes.legend(
            handles=[
                Patch(color=GREEN, alpha=0.45, label="alarm wanted"),
                Patch(color=GREY, alpha=0.35, label="silence wanted"),
                Line2D([], [], color=BLACK, linewidth=4, label="alarm"),
                Line2D([], [], color=VERMILION, linewidth=4, label="false alarm"),
                Line2D([], [], color=BLUE, marker="x", linestyle="", label="contact"),
            ],
            ncols=5,
            loc="lower center",
            bbox_to_anchor=(0.5, 1.0),
        )
        few = "" if len(rows) == len(evaluation.clips) else f"; the {len(rows)} with the smallest margin"
        figure.suptitle(f"{name}: {headline(evaluation)}{few}")


def operating_figure(path: str | os.PathLike, evaluation: Evaluation) -> None:
    """On the fitted clips: hits against false alarms over all T_sp, both over T_sp itself, and the time to contact."""
    highest = max(float(trace.max(initial=0.5)) for trace in evaluation.evidence)
    thresholds = np.linspace(0.5, min(highest + 0.02, 1.0), _STEPS)
    hits, false = evaluation.operating_curve(thresholds)
    score, most = evaluation.score(), max(float(false.max()), 1e-9)
    warnings = [verdict.warning_ms for verdict in evaluation.verdicts() if not np.isnan(verdict.warning_ms)]
    with drawn(path, 10, 3.4) as figure:
        curve, over, lead = figure.subplots(1, 3)
        curve.plot(false, hits, color=BLUE)
        curve.plot(
            score.false_alarms.value, score.hits.value, "o", color=VERMILION, label=f"T_sp = {evaluation.T_sp:.3f}"
        )
        curve.set(xlabel="false alarms a minute", ylabel="windows hit", ylim=(-0.03, 1.03), xlim=(-0.03 * most, None))
        curve.set_title("fitted clips")
        curve.legend(loc="lower right")
        over.plot(thresholds, hits, color=GREEN, label="windows hit")
        over.plot(thresholds, false / most, color=BLACK, label="false alarms (1: the most)")
        over.axvline(evaluation.T_sp, color=VERMILION, linestyle="--", linewidth=1)
        over.set(xlabel="T_sp (adapted SMP)", ylabel="share", ylim=(-0.03, 1.03))
        over.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=2)
        if warnings:
            lead.hist(warnings, bins=min(20, len(warnings)), color=BLUE, alpha=0.7)
        lead.axvline(0, color=BLUE, linestyle=":", linewidth=1)
        lead.set(xlabel="first alarm before contact (ms)", ylabel="windows")


def comparison_figure(path: str | os.PathLike, comparison: Comparison) -> None:
    """Hits against false alarms a minute of all detectors, with 95 % intervals, and each over all its thresholds.

    A filled mark is a detector at its own threshold, an open one at a budget of false alarms. A line follows all
    thresholds on the same clips, so that it flatters where the open marks do not.
    """
    with drawn(path, 7, 4.6) as figure:
        axes = figure.subplots()
        for (name, compared), colour, mark in zip(comparison.detectors.items(), COLOURS, MARKS, strict=False):
            levels = np.concatenate(compared.evaluation.evidence)
            hits, false = compared.evaluation.operating_curve(np.quantile(levels, np.linspace(0, 1, _STEPS)))
            axes.plot(false, hits, color=colour, alpha=0.4, linewidth=1)
            for outcome in compared.at_budgets.values():
                _cross(axes, outcome.counts.score(), color=colour, marker=mark, markerfacecolor="none")
            if compared.own is not None:
                _cross(axes, compared.own.counts.score(), color=colour, marker=mark, markersize=8)
            axes.plot([], [], color=colour, marker=mark, label=TITLES.get(name, name))
        most = max(
            outcome.counts.score().false_alarms.high
            for compared in comparison.detectors.values()
            for outcome in [*compared.at_budgets.values(), *([] if compared.own is None else [compared.own])]
        )
        axes.set(xlabel="false alarms a minute", ylabel="windows hit", ylim=(-0.03, 1.03), xlim=(-0.03 * most, most))
        axes.legend(ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))


def _cross(axes: Axes, score: Score, **style) -> None:
    """A point with the intervals of hits and of false alarms."""
    (x, left, right), (y, low, high) = score.false_alarms, score.hits
    axes.errorbar(
        x, y, xerr=[[x - left], [right - x]], yerr=[[y - low], [high - y]], elinewidth=0.7, linestyle="", **style
    )


def worst_figure(path: str | os.PathLike, evaluation: Evaluation) -> None:
    """The clips with the smallest margin: what is seen, and the evidence for an alarm with T_sp."""
    rows = _by_margin(evaluation)[:_WORST]
    with drawn(path, 10, 2.9 * len(rows)) as figure:
        grid = figure.add_gridspec(2 * len(rows), _PICTURES, height_ratios=[1.0, 1.3] * len(rows))
        for row, (clip, trace, verdict) in enumerate(rows):
            places = _moments(clip, trace)
            for column, place in enumerate(places):
                axes = figure.add_subplot(grid[2 * row, column])
                if isinstance(clip, LabelledClip):
                    axes.imshow(clip.frames[place], cmap="gray", vmin=0, vmax=255, aspect="equal")
                axes.set_title(f"{clip.time[place] / 1000:.2f} s", fontsize=7, pad=2)
                axes.set_axis_off()
            axes = figure.add_subplot(grid[2 * row + 1, :])
            seconds = clip.time / 1000
            for inside in clip.in_windows():
                axes.fill_between(
                    seconds, 0, 1, where=inside, transform=axes.get_xaxis_transform(), color=GREEN, alpha=0.2
                )
            axes.fill_between(
                seconds, 0, 1, where=clip.in_silence(), transform=axes.get_xaxis_transform(), color=GREY, alpha=0.15
            )
            axes.plot(seconds, np.maximum(trace, 0.4), color=BLACK)
            axes.axhline(evaluation.T_sp, color=VERMILION, linestyle="--", linewidth=1)
            axes.plot(seconds[places], np.maximum(trace[places], 0.4), "o", color=BLUE, markersize=4)
            axes.set(ylabel="evidence", xlim=(seconds[0], seconds[-1]))
            judgement = "correct" if verdict.right else "wrong"
            axes.set_title(f"{clip.name}: {judgement}, margin {verdict.margin:+.3f}", loc="left", fontsize=8)
            if row == len(rows) - 1:
                axes.set_xlabel("time (s); green: alarm wanted, grey: silence wanted; dashed: T_sp")


def reliability_figure(path: str | os.PathLike, found: Reliability, within_ms: float) -> None:
    """The reliability diagram, and how many frames there are of each predicted probability."""
    observed = np.array([share[:3] for share in found.observed])
    errors = np.abs(observed[:, 1:] - observed[:, :1]).T
    with drawn(path, 8, 3.4) as figure:
        diagram, counts = figure.subplots(1, 2)
        diagram.plot([0, 1], [0, 1], color=GREY, linestyle="--", linewidth=1)
        diagram.errorbar(found.predicted, observed[:, 0], errors, fmt="o-", color=BLUE, capsize=2)
        diagram.set(xlabel=f"predicted probability of contact within {within_ms:g} ms", ylabel="observed frequency")
        diagram.set(xlim=(-0.03, 1.03), ylim=(-0.03, 1.03))
        diagram.set_title(
            f"Brier score {found.brier.value:.4f}; of a constant {found.brier_of_the_mean:.4f}", fontsize=9
        )
        counts.bar(found.predicted, found.frames, width=0.07, color=BLUE)
        counts.set(xlabel="predicted probability", ylabel="frames", yscale="log", xlim=(-0.05, 1.05))


def _by_margin(evaluation: Evaluation) -> list[tuple[ClipLabels, np.ndarray, Verdict]]:
    rows = list(zip(evaluation.clips, evaluation.evidence, evaluation.verdicts(), strict=True))
    return sorted(rows, key=lambda row: (row[2].right, np.nan_to_num(row[2].margin, nan=np.inf)))


def _bars(axes: Axes, clip: ClipLabels, on: np.ndarray, y: int, colour: str, alpha: float, height: float) -> None:
    half = 500 / clip.fps
    spans = [((clip.time[a] - half) / 1000, (clip.time[b] - clip.time[a] + 2 * half) / 1000) for a, b in stretches(on)]
    axes.broken_barh(spans, (y - height / 2, height), color=colour, alpha=alpha, linewidth=0)


def _moments(clip: ClipLabels, trace: np.ndarray) -> np.ndarray:
    """Frames evenly spread, among them the judged one of the strongest evidence."""
    places = np.linspace(0, len(trace) - 1, _PICTURES).round().astype(int)
    judged = clip.in_silence() | clip.in_windows().any(axis=0)
    peak = int(np.argmax(np.where(judged, trace, -1)))
    places[np.argmin(np.abs(places - peak))] = peak
    return places
