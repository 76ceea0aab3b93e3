"""The figure of fits side by side: how far each is from each curve, and with how many parameters."""

import os

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from lgmd2jax._channels import TARGETS
from lgmd2jax._figures.style import COLOURS, GREY, MARKS, check_count, drawn
from lgmd2jax.fitting import Comparison

_LINE = 0.21  # inches a curve


def comparison_figure(path: str | os.PathLike, comparison: Comparison) -> None:
    """Chi2 and the unexplained share of each curve, a mark a fit, and beside them what holds in all, at `path`.

    **Raises:** `ValueError` for more fits than there are colours.
    """
    check_count(len(comparison.names), "fits")
    labels = [f"{condition}, {TARGETS[channel].label}" for condition, channel in comparison.curves]
    with drawn(path, 13, max(4.2, 1.6 + _LINE * len(labels))) as figure:
        figure.suptitle(f"{len(comparison.names)} fits to the same {len(labels)} curves, hard models")
        chi2, unexplained, in_all = figure.subplots(1, 3, width_ratios=(1, 1, 1))
        _rows(chi2, comparison.chi2)
        chi2.set(title="χ² of each curve", xlabel="χ²")
        chi2.set_yticks(range(len(labels)), labels, fontsize=8 if len(labels) < 16 else 6)
        _rows(unexplained, 1 - comparison.r2)
        _left_out(unexplained, comparison)
        unexplained.tick_params(labelleft=False)
        _in_all(in_all, comparison)


def _rows(axes: Axes, values: np.ndarray) -> None:
    """A row a curve, the first one on top; a mark a fit, the first one lowest in its row."""
    fits, places = len(values), np.arange(values.shape[1])
    for i, (row, colour, mark) in enumerate(zip(values, COLOURS, MARKS, strict=False)):
        axes.plot(row, places + 0.6 * (i / max(fits - 1, 1) - 0.5), mark, color=colour, markersize=4.5)
    for place in places[:-1]:
        axes.axhline(place + 0.5, color=GREY, linewidth=0.4)
    axes.set(ylim=(len(places) - 0.5, -0.5), xscale=_scale(axes, values))
    axes.grid(visible=False, axis="y")


def _scale(axes: Axes, values: np.ndarray) -> str:
    """Logarithmic, if there is anything above 0 to show; of values that nobody knows the panel says so."""
    if np.isnan(values).all():
        axes.text(0.5, 0.5, "not known: no fit tells\nits targets' errors", transform=axes.transAxes, ha="center")
    return "log" if np.any(values > 0) else "linear"


def _left_out(axes: Axes, comparison: Comparison) -> None:
    """Hollow marks where a condition was predicted by a fit to others, in the row of its first curve."""
    rows: dict[str, int] = {}
    for place, (condition, _) in enumerate(comparison.curves):
        rows.setdefault(condition, place)
    fits = len(comparison.names)
    for condition, r2 in comparison.left_out.items():
        for i, (value, colour, mark) in enumerate(zip(1 - r2, COLOURS, MARKS, strict=False)):
            place = rows[condition] + 0.6 * (i / max(fits - 1, 1) - 0.5)
            axes.plot(value, place, mark, color=colour, markerfacecolor="white", markersize=4.5)
    hollow = "\n(hollow: its condition left out of the fit)" if comparison.left_out else ""
    axes.set(title=f"unexplained share of each curve{hollow}", xlabel="1 - R²")


def _in_all(axes: Axes, comparison: Comparison) -> None:
    """Chi2 over the number of free parameters; the key tells what else holds in all."""
    for i, (name, colour, mark) in enumerate(zip(comparison.names, COLOURS, MARKS, strict=False)):
        words = [f"{name}: R² {comparison.r2_in_all[i]:.3f}"]
        if np.isfinite(comparison.left_out_in_mean[i]):
            words.append(f"left out {comparison.left_out_in_mean[i]:.3f}")
        if np.isfinite(comparison.bic[i]):
            words.append(f"BIC {comparison.bic[i]:.0f}")
        if comparison.properties is not None:
            words.append(f"{comparison.properties[i]} properties")
        place = comparison.free[i], comparison.chi2_in_all[i]
        axes.plot(*place, mark, color=colour, markersize=7, linestyle="", label=", ".join(words))
        axes.annotate(name, place, (7, 0), textcoords="offset points", va="center", fontsize=8)
    scale = _scale(axes, comparison.chi2_in_all)
    axes.set(title="χ² in all", xlabel="free parameters", ylabel="χ²", yscale=scale)
    axes.margins(y=0.1)
    axes.set_xlim(comparison.free.min() - 1, comparison.free.max() + 2)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), fontsize=7.5)
