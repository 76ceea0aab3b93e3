"""The figure of an exam: how response properties depend on the stimulus, model by model, and which of them hold."""

import os
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from lgmd2jax._characterise import Characterisation
from lgmd2jax._characterise.panels import OVER
from lgmd2jax._figures.style import COLOURS, GREEN, GREY, MARKS, ORANGE, SKY, check_count, drawn

_TIMES = "peak time before collision (ms)"
_CHANGES = "largest R, change of light"
_PASS, _FAIL, _OPEN = SKY, ORANGE, "#dddddd"

# Title of each panel, with the rows that it belongs to, and the bounds that hold in it.
_TITLES: dict[str, tuple[str, float | None, float | None]] = {
    _TIMES: ("1, 2  time of the peak", None, None),
    "angle at t_peak - D (deg)": ("3  threshold angle", 15, 40),
    "peak R, approach": ("6  size of the peak", None, None),
    "peak R, contrast": ("18  contrast", None, None),
    "peak R, speed": ("13, 15  speed of translation", None, None),
    "peak R, direction": ("13  direction", None, None),
    "peak R, deviation": ("21  near misses", None, None),
    "mean R, grating": ("16  gratings, 300 to 2,000 ms", 0, 0.1),
    _CHANGES: ("17  changes of light", 0, 0.15),
    "peak R, objects": ("9 to 13  what is answered", None, None),
}


def characterisation_figure(path: str | os.PathLike, models: Mapping[str, Characterisation]) -> None:
    """Small panels, a colour for each model, and which rows hold, at `path`.

    **Raises:** `ValueError` for more models than there are colours.
    """
    check_count(len(models), "models")
    with drawn(path, 13, 10.6 + 0.3 * len(models)) as figure:
        grid = figure.add_gridspec(4, 12, height_ratios=(1, 1, 1, 0.28 + 0.13 * len(models)))
        names = list(OVER)
        for i, name in enumerate(names[:8]):
            row, column = divmod(i, 4)
            _panel(figure, grid[row, 3 * column : 3 * column + 3], name, models)
        _panel(figure, grid[2, :7], names[8], models)
        _panel(figure, grid[2, 7:], names[9], models)
        handles, labels = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(models))
        _verdicts(figure.add_subplot(grid[3, :]), models)


def _panel(figure: Figure, place: SubplotSpec, name: str, models: Mapping[str, Characterisation]) -> None:
    axes, (over, places) = figure.add_subplot(place), OVER[name]
    words = isinstance(places[0], str)
    x = np.arange(len(places)) if words else np.array(places)
    title, low, high = _TITLES[name]
    if low is not None and high is not None:
        axes.axhspan(low, high, color=GREEN, alpha=0.13, linewidth=0)
    for i, ((model, result), colour, mark) in enumerate(zip(models.items(), COLOURS, MARKS, strict=False)):
        aside = 0.14 * (i - (len(models) - 1) / 2) if words else 0  # so that equal values are all seen
        line = "" if words or name == _TIMES else "-"
        axes.plot(x + aside, result.panels[name], mark, color=colour, markersize=4.5, linestyle=line, label=model)
    axes.set_title(title, loc="left")
    axes.set(xlabel=over, ylabel=name.split(",")[0])
    _ticks(axes, name, places, x)
    if name == _TIMES:
        _fitted_lines(axes, x, models)
    elif name == "peak R, approach":
        axes.set(xscale="log")
        axes.set_xticks(x, [f"{value:g}" for value in x], minor=False)
        axes.minorticks_off()
    if name.startswith(("peak R", "mean R", "largest R")):
        bottom, top = axes.get_ylim()
        room = 1.2 if name == _CHANGES else 1.08
        axes.set_ylim(min(-0.03, bottom), room * max(top, 2 * (high or 0.5)))


def _ticks(axes: Axes, name: str, places, x) -> None:
    if name == _CHANGES:
        axes.set_xticks(x, [place.split()[2] + ("\nin 1 s" if place.endswith("1 s") else "") for place in places])
        for i in range(0, len(places), 4):
            part, way, *_ = places[i].split()
            axes.text(i + 1.5, 0.97, f"{part} {way}", ha="center", va="top", transform=axes.get_xaxis_transform())
            if i:
                axes.axvline(i - 0.5, color=GREY, linewidth=0.6)
        axes.set_xlabel("grey levels")
    elif isinstance(places[0], str):
        axes.set_xticks(x, [place.replace("0.", ".") for place in places])
    elif name == "peak R, direction":
        axes.set_xticks(x)


def _fitted_lines(axes: Axes, x: np.ndarray, models: Mapping[str, Characterisation]) -> None:
    """The line alpha l/|v| - delta, with the frame put back that is taken off delta."""
    far = np.array([0, x[-1]])
    for result, colour in zip(models.values(), COLOURS, strict=False):
        alpha, delta = (result.selectivity[name].value for name in ("alpha", "delta"))
        axes.plot(far, alpha * far - delta - 1000 / result.eye.fps, color=colour, linewidth=1)
    axes.plot(far, 4.4 * far - 18.7, color=GREY, linestyle=(0, (4, 3)), linewidth=1)
    axes.annotate("locust", (far[1], 4.4 * far[1] - 18.7), (-4, 0), textcoords="offset points", ha="right", color=GREY)


def _verdicts(axes: Axes, models: Mapping[str, Characterisation]) -> None:
    """A square for each row of each model."""
    colours = {True: _PASS, False: _FAIL, None: _OPEN}
    marks = {True: "", False: "x", None: "-"}
    for i, result in enumerate(models.values()):
        for row in result.rows:
            axes.barh(i, 0.94, 0.88, row.number - 0.47, color=colours[row.passed])
            axes.text(row.number, i, marks[row.passed], ha="center", va="center", fontsize=8)
    axes.set_yticks(range(len(models)), [f"{name}  {result.passed}/{result.judged}" for name, result in models.items()])
    axes.set_xticks(range(1, 23), [f"{number}" for number in range(1, 23)])
    axes.set(xlim=(0.5, 22.5), ylim=(len(models) - 0.5, -0.5))
    axes.set_title("which of the 22 hold (x: fails; -: not judged); green above: where they do", loc="left")
    axes.grid(False)
    axes.tick_params(length=0)
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)
