"""The figures of a fit: every condition's curves, and how it was found and how well it is determined."""

import os
import textwrap
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from lgmd2jax._channels import TARGETS, Channel
from lgmd2jax._figures.style import BLACK, BLUE, GREY, VERMILION, drawn
from lgmd2jax.fitting import Curve, Fit, Run, Uncertainty
from lgmd2jax.fitting._curve import DISAGREEMENT
from lgmd2jax.fitting._report import grades

_HEIGHTS = {"rate": 1.9, "smp_adapted": 1.5, "smp": 1.5, "spikes": 0.9}  # of a panel, in inches
_COLUMNS = 5  # at most
_PAGE, _NARROWEST, _WIDEST = 9.0, 2.3, 5.5  # inches: of a page with few panels, and of a panel
_LETTERS = 16  # of a condition's name, on an inch
_BAND = 1.96  # standard errors that hold 95 %
_BARS = 10  # that the panel of gaps has room for at least, so that few are not thick
_DECADES = 12  # below the highest, that a logarithmic axis shows
_TERMS, _TELLING = 3, 0.25  # parameters by which a direction is named: how many, and from which component on


def fit_figure(path: str | os.PathLike, curves: Sequence[Curve], name: str) -> None:
    """Every condition with a panel for each of its channels: target, soft model and hard model over time.

    All panels of a channel have the same axis, so that conditions compare. The target is drawn where it counts. A block
    of conditions has rows for the channels that some of them have.
    """
    with drawn(path, *curves_size(curves)) as figure:
        draw_curves(figure, curves, name)


class _Layout(NamedTuple):
    """The conditions, how many stand side by side, how wide a panel is, and for each row its block and channel."""

    conditions: list[dict[Channel, Curve]]
    columns: int
    panel: float
    rows: list[tuple[int, Channel]]

    @property
    def heights(self) -> list[float]:
        return [_HEIGHTS[channel] for _, channel in self.rows]


def _layout(curves: Sequence[Curve]) -> _Layout:
    conditions = _conditions(curves)
    channels: list[Channel] = [channel for channel in TARGETS if any(channel in condition for condition in conditions)]
    blocks = -(-len(conditions) // _COLUMNS)
    columns = -(-len(conditions) // blocks)
    rows: list[tuple[int, Channel]] = [
        (block, channel)
        for block in range(blocks)
        for channel in channels
        if any(channel in condition for condition in conditions[block * columns : (block + 1) * columns])
    ]
    return _Layout(conditions, columns, min(max(_PAGE / columns, _NARROWEST), _WIDEST), rows)


def curves_size(curves: Sequence[Curve]) -> tuple[float, float]:
    """Width and height of the figure of these curves, in inches."""
    _, columns, panel, _ = layout = _layout(curves)
    heights = layout.heights
    return max(0.7 + panel * columns, 6.5), 1.1 + sum(heights) + 0.4 * len(heights)


def draw_curves(figure: Figure, curves: Sequence[Curve], name: str) -> None:
    """The panels of `fit_figure` on an empty figure."""
    conditions, columns, panel, rows = layout = _layout(curves)
    limits = {channel: _limits([curve for curve in curves if curve.channel == channel]) for _, channel in rows}
    heights = layout.heights
    figure.suptitle(_verdict(curves, name))
    grid = figure.subplots(len(heights), columns, squeeze=False, gridspec_kw={"height_ratios": heights})
    legend, labelled = {}, set()
    for i, condition in enumerate(conditions):
        block, column = divmod(i, columns)
        panels = [grid[rows.index((block, channel)), column] for channel in condition]
        for axes, curve in zip(panels, condition.values(), strict=True):
            _panel(axes, curve, limits[curve.channel])
            legend |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
            first = (block, curve.channel) not in labelled
            labelled.add((block, curve.channel))
            axes.set_ylabel(_axis_label(curve.channel) if first else "")
            axes.tick_params(labelleft=first, labelbottom=axes is panels[-1])
        title = textwrap.fill(next(iter(condition.values())).condition, int(_LETTERS * panel))
        panels[0].set_title(f"{title}\n{panels[0].get_title(loc='left')}", loc="left", fontsize=8)
        if i + columns >= len(conditions):
            panels[-1].set_xlabel("time (ms)")
    for axes in grid.flat:
        if not axes.has_data():
            axes.remove()
    figure.legend(legend.values(), legend.keys(), loc="outside lower center", ncols=len(legend))


def _axis_label(channel: Channel) -> str:
    described = TARGETS[channel]
    return f"{described.label} ({described.unit})" if channel == "rate" else described.label


def _conditions(curves: Sequence[Curve]) -> list[dict[Channel, Curve]]:
    """The curves of each condition by channel. A channel that comes again begins a new one, for names may repeat."""
    conditions, name = [], None
    for curve in curves:
        if curve.condition != name or curve.channel in conditions[-1]:
            conditions.append({})
        conditions[-1][curve.channel], name = curve, curve.condition
    return [{channel: curves[channel] for channel in TARGETS if channel in curves} for curves in conditions]


def _verdict(curves: Sequence[Curve], name: str) -> str:
    """How many targets the hard model meets how well. R2 says little of what hardly varies, so all are counted."""
    explained = [r2 for curve in curves if not np.isnan(r2 := curve.r2())]
    low, high = (min(explained), max(explained)) if explained else (0.0, 0.0)
    explains = f", R² {low:.3f}" + (f" to {high:.3f}" if len(explained) > 1 else "") if low > 0 else ""
    return f"Fit {name}, hard model on {len(curves)} targets: {grades(curves)}{explains}"


def _limits(curves: Sequence[Curve]) -> tuple[float, float]:
    """What holds all curves of a channel. Prediction bands may leave it: an undetermined one would flatten the rest."""
    drawn_values = [values for curve in curves for values in (*_counted(curve), curve.soft, curve.hard)]
    drawn_values += [_counted(curve)[0] + sign * curve.sem for curve in curves for sign in (-1, 1)]
    together = np.concatenate(drawn_values)
    together = together[np.isfinite(together)]
    low, high = together.min(), together.max()
    margin = 0.06 * max(high - low, 0.02)
    return float(low - margin), float(high + margin)


def _counted(curve: Curve) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper edge of the target where it counts; of a curve they are the same."""
    return np.where(curve.weight > 0, curve.target, np.nan), np.where(curve.weight > 0, curve.high, np.nan)


def _panel(axes: Axes, curve: Curve, limits: tuple[float, float]) -> None:
    (target, upper), band = _counted(curve), np.where(np.isfinite(curve.band), _BAND * curve.band, 0)
    axes.axvline(0, color=GREY, linewidth=0.8)
    if curve.is_band:
        edges = np.clip(target, *limits), np.clip(upper, *limits)  # an infinite one reaches to the border
        axes.fill_between(curve.time, *edges, color=GREY, alpha=0.6, linewidth=0.8, step="mid", label="target band")
        target = np.full(len(target), np.nan)
    if np.isfinite(curve.sem).any():
        low, high = target - curve.sem, target + curve.sem
        axes.fill_between(curve.time, low, high, color=GREY, alpha=0.4, linewidth=0, label="target, s.e.m.")
    if band.any():
        low, high = curve.soft - band, curve.soft + band
        axes.fill_between(curve.time, low, high, color=BLUE, alpha=0.2, linewidth=0, label="soft, 95 % band")
    drawstyle = "steps-mid" if curve.channel == "spikes" else "default"
    counted = np.pad(np.isfinite(target), 1)
    alone = counted[1:-1] & ~counted[:-2] & ~counted[2:]
    if alone.any():  # no line leads to a value whose neighbours do not count
        axes.plot(curve.time[alone], target[alone], ".", color=BLACK)
    for label, values, colour, width, dashes in (
        ("target", target, BLACK, 2.2, "-"),
        ("soft", curve.soft, BLUE, 1.2, "-"),
        ("hard, handed over", curve.hard, VERMILION, 1.2, (0, (4, 2))),
    ):
        if np.isfinite(values).any():
            style = {"color": colour, "linewidth": width, "linestyle": dashes, "drawstyle": drawstyle}
            axes.plot(curve.time, values, label=label, **style)
    if curve.gap > DISAGREEMENT:
        words = f"soft ≠ hard, {curve.gap:.0%}"
        axes.annotate(words, (0.02, 0.96), xycoords="axes fraction", va="top", color=VERMILION, weight="bold")
    axes.set_title(_quality(curve), loc="left", fontsize=8)
    axes.set(xlim=(curve.time[0], curve.time[-1]), ylim=limits)
    axes.xaxis.set_major_locator(MaxNLocator(4))
    axes.yaxis.set_major_locator(MaxNLocator(3, integer=True) if curve.channel == "spikes" else MaxNLocator(5))


def _quality(curve: Curve) -> str:
    if curve.is_band:
        shares = f"{curve.inside():.0%} within (soft {curve.inside('soft'):.0%})"
        return f"{curve.grade}: {shares}\nsilence {curve.inside('silence'):.0%}, RMSE {curve.rmse():.2g}"
    hard, soft = curve.r2("hard"), curve.r2("soft")
    explained = "flat target" if np.isnan(hard) else f"R² {hard:.3g} (soft {soft:.3g})"
    return f"{curve.grade}: {explained}\nRMSE {curve.rmse('hard'):.2g}, of silence {curve.rmse('silence'):.2g}"


def diagnostics_figure(path: str | os.PathLike, fit: Fit) -> None:
    """How the fit was found, how well it is determined, and whether soft and hard agree."""
    with drawn(path, 13, 7.3) as figure:
        figure.suptitle(textwrap.fill(" | ".join(fit.status), 130))
        ((left, right),) = figure.subfigures(1, 2, squeeze=False, width_ratios=(2.7, 1))
        above, below = left.subfigures(2, 1, height_ratios=(1, 1.25))
        screened, descended, history = above.subplots(1, 3, width_ratios=(1, 0.7, 1.4))
        _waterfall(screened, descended, fit)
        _history(history, fit.runs, fit.temperatures)
        correlation, spectrum = below.subplots(1, 2)
        _correlation(correlation, fit.uncertainty)
        _spectrum(spectrum, fit.uncertainty)
        _gaps(right.subplots(), fit.curves)


def _waterfall(screened: Axes, descended: Axes, fit: Fit) -> None:
    """Losses from the best to the worst: of the points of the search, and of the descents with where they began."""
    ranks = np.arange(1, len(fit.screened) + 1)
    starts, ends = (np.array([getattr(run, name) for run in fit.runs]) for name in ("start_loss", "loss"))
    floor = _floor([*fit.screened, *starts, *ends])
    screened.plot(ranks, np.maximum(fit.screened, floor), ".", color=GREY)
    screened.set(title=f"{len(fit.screened)} starts screened", xlabel="rank", ylabel="loss (half sum of squares)")
    ranks = np.arange(1, len(ends) + 1)
    descended.vlines(ranks, np.maximum(ends, floor), np.maximum(starts, floor), color=GREY, linewidth=1)
    descended.plot(ranks, np.maximum(starts, floor), "o", color=GREY, markerfacecolor="white", label="start")
    descended.plot(ranks, np.maximum(ends, floor), "o", color=VERMILION, label="end")
    descended.set(title=f"best found {fit.best_count} of {len(ends)} times", xlabel="descent")
    descended.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    descended.legend()
    descended.sharey(screened)
    screened.set_yscale("log")
    descended.tick_params(labelleft=False)


def _floor(values) -> float:
    """What stands for nothing on a logarithmic axis: below all that is seen, but not by endless decades."""
    positive = [value for value in values if np.isfinite(value) and value > 0]
    return max(min(positive) / 2, max(positive) * 10.0**-_DECADES) if positive else 1.0


def _history(axes: Axes, runs: Sequence[Run], temperatures: Sequence[float]) -> None:
    """The loss after every step; at each temperature all runs begin at one line."""
    stages = [[run.history[i] for run in runs if i < len(run.history)] for i in range(len(temperatures))]
    longest = [max(map(len, stage), default=0) for stage in stages]
    begins = np.concatenate([[0], np.cumsum([length + 1 for length in longest])])
    floor = _floor([loss for run in runs for losses in run.history for loss in losses])
    for number, run in reversed(list(enumerate(runs))):
        best = number == 0
        for begin, losses in zip(begins, run.history, strict=False):
            axes.plot(
                begin + np.arange(1, len(losses) + 1),
                np.maximum(losses, floor),
                color=BLUE if best else GREY,
                linewidth=2 if best else 0.9,
                marker="." if best or len(losses) == 1 else "",
                label="best" if best else "other descents",
                zorder=3 if best else 2,
            )
    for begin in begins[:-1]:
        axes.axvline(begin, color=BLACK, linewidth=0.8, linestyle=":")
    above = axes.secondary_xaxis("top")
    above.set_xticks(begins[:-1], [f"{temperature:g}" for temperature in temperatures])
    above.set_xlabel("temperature from here on")
    axes.set(xlabel="step of the solver", ylabel="loss of the soft model", yscale="log")
    axes.set_xlim(0, max(begins[-1], 1))
    labels = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    axes.legend(labels.values(), labels.keys(), loc="upper right", frameon=True, framealpha=1, edgecolor="none")


def _correlation(axes: Axes, uncertainty: Uncertainty) -> None:
    names, values = uncertainty.names, np.asarray(uncertainty.correlation)
    axes.set_facecolor(GREY)  # seen where there is no number
    axes.imshow(values, vmin=-1, vmax=1, cmap="PuOr")
    axes.grid(False)
    axes.set_xticks(range(len(names)), names, rotation=90)
    axes.set_yticks(range(len(names)), names)
    for (row, column), value in np.ndenumerate(values):
        if row != column and np.isfinite(value):
            axes.text(
                column,
                row,
                f"{round(value, 1) + 0:.1f}",
                ha="center",
                va="center",
                fontsize=6,
                color="white" if abs(value) > 0.7 else BLACK,
            )
    axes.set_title("correlation of the errors" + ("" if np.isfinite(values).all() else "\n(grey: undetermined)"))


def _spectrum(axes: Axes, uncertainty: Uncertainty) -> None:
    """A bar for each direction, the stiffest at the top, named by the parameters that move together along it."""
    values = uncertainty.spectrum
    floor = _floor([*values, 1.0])
    places = np.arange(len(values))
    axes.hlines(places, floor, np.maximum(values, floor), color=GREY, linewidth=1)
    axes.plot(np.maximum(values, floor), places, "o", color=BLUE)
    # An eigenvalue is 1/(standard error along its direction, in the bounds' width) squared.
    axes.axvline(1, color=VERMILION, linestyle=(0, (4, 2)), label="error as wide as the bounds")
    axes.legend(loc="lower left")
    names = [_direction(uncertainty.names, uncertainty.directions[:, i]) for i in places]
    names[0] = f"stiffest: {names[0]}"
    if len(names) > 1:
        names[-1] = f"sloppiest: {names[-1]}"
    axes.set_yticks(places, names, fontsize=7)
    axes.set(title="sensitivity spectrum", xlabel="eigenvalue of the information", xscale="log")
    axes.set_ylim(len(values) + 0.6, -0.6)


def _direction(names: Sequence[str], direction: np.ndarray) -> str:
    """Its largest components, the largest one positive."""
    largest = np.argsort(-np.abs(direction))[:_TERMS]
    signed = direction * np.sign(direction[largest[0]])
    terms = [f"{signed[i]:+.1f} {names[i]}" for i in largest if abs(signed[i]) >= _TELLING]
    return " ".join(terms).removeprefix("+")


def _gaps(axes: Axes, curves: Sequence[Curve]) -> None:
    """How far soft and hard lie apart in each curve."""
    places, gaps = np.arange(len(curves)), np.array([100 * curve.gap for curve in curves])
    over = gaps > 100 * DISAGREEMENT
    bars = axes.barh(places, gaps, color=np.where(over, VERMILION, BLUE))
    for bar, high in zip(bars, over, strict=True):
        bar.set_hatch("///" if high else "")
    paper = {"facecolor": "white", "edgecolor": "none", "pad": 0.5}
    axes.bar_label(bars, fmt=lambda gap: f"{gap:.2g}" if gap >= 0.01 else "0", padding=2, fontsize=6, bbox=paper)
    axes.axvline(100 * DISAGREEMENT, color=BLACK, linestyle=(0, (4, 2)), linewidth=0.8, label="limit of a remark")
    axes.legend(loc="lower right")
    labels = [f"{curve.condition}, {TARGETS[curve.channel].label}" for curve in curves]
    axes.set_yticks(places, labels, fontsize=7 if len(curves) < 16 else 6)
    axes.set(title="gap of soft and hard", xlabel="% of the span", ylim=(max(len(curves), _BARS) + 0.6, -0.6))
    axes.set_xlim(0, 1.2 * max(gaps.max(), 100 * DISAGREEMENT))
