"""The figure of a sweep: a surface over two axes, with its contours, and profiles along both."""

import os
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FormatStrFormatter, LogLocator, MaxNLocator, NullFormatter

from lgmd2jax._figures.style import BLACK, BLUE, VERMILION, drawn

_LEVELS = 6  # contours at most


def surface_figure(
    path: str | os.PathLike, responses: Any, value: str, index: str | None, thresholds: Mapping[str, float], title: str
) -> None:
    """A heat map of one summary over two axes, thresholds drawn, with median and quartiles along each.

    **Arguments:** `responses`: an `xarray.Dataset`. `index`: a third axis of two values a and b, along which
    (a - b)/(a + b) is shown instead. `thresholds`: levels that are drawn, by what they are called.
    """
    surface, meaning = responses[value].squeeze(drop=True), responses[value].attrs["long_name"]
    unit, limits = surface.attrs["units"], None
    label = value + ("" if unit == "1" else f" ({unit})")
    if index is not None:
        a, b = (surface.isel({index: i}, drop=True) for i in (0, 1))
        first, second = (f"{index} {end:g}" for end in responses[index].values)
        surface, limits = (a - b) / (a + b).where(a + b > 0), (-1.0, 1.0)
        label = f"index of {value}: 1 if {first} alone is answered, -1 if {second}"
    rows, columns = surface.dims
    x, y, z = responses[columns], responses[rows], surface.values
    with drawn(path, 7.6, 6) as figure:
        figure.suptitle(f"{title}: {meaning}")
        grid = figure.add_gridspec(2, 2, width_ratios=(4, 1.2), height_ratios=(1, 4))
        axes = figure.add_subplot(grid[1, 0])
        top = figure.add_subplot(grid[0, 0], sharex=axes)
        right = figure.add_subplot(grid[1, 1], sharey=axes)
        low, middle, high = np.nanpercentile(z, (25, 50, 75), axis=0)
        top.fill_between(x, low, high, color=BLUE, alpha=0.2, linewidth=0)
        top.plot(x, middle, color=BLUE)
        top.set_title(f"median and quartiles over {rows}", loc="left")
        low, middle, high = np.nanpercentile(z, (25, 50, 75), axis=1)
        right.fill_betweenx(y, low, high, color=BLUE, alpha=0.2, linewidth=0)
        right.plot(middle, y, color=BLUE)
        right.set_title(f"over\n{columns}", loc="left")
        _map(figure, axes, x.values, y.values, z, label, limits, thresholds)
        for coordinate, axis, set_scale in ((x, axes.xaxis, axes.set_xscale), (y, axes.yaxis, axes.set_yscale)):
            unit = coordinate.attrs.get("units", "1")
            axis.set_label_text(coordinate.name + (f" ({unit})" if unit not in ("", "1") else ""))
            _scale(axis, set_scale, coordinate.values)
        top.tick_params(labelbottom=False)
        right.tick_params(labelleft=False)


def _map(
    figure: Figure,
    axes: Axes,
    x: np.ndarray,
    y: np.ndarray,
    z: np.ndarray,
    label: str,
    limits: tuple[float, float] | None,
    thresholds: Mapping[str, float],
) -> None:
    low, high = float(np.nanmin(z)), float(np.nanmax(z))
    colours, norm = ("viridis", Normalize(low, high)) if limits is None else ("PuOr_r", Normalize(*limits))
    picture = axes.pcolormesh(x, y, z, cmap=colours, norm=norm, shading="nearest", rasterized=True)
    axes.grid(False)
    bar = figure.colorbar(picture, ax=axes, location="bottom", label=label, shrink=0.8, aspect=40)
    levels = [level for level in MaxNLocator(_LEVELS).tick_values(low, high) if low < level < high]
    if levels:
        bar.add_lines(axes.contour(x, y, z, levels=levels, colors=BLACK, linewidths=0.5, linestyles="solid"))
    for name, level in thresholds.items():
        if low < level < high:
            line = axes.contour(x, y, z, levels=[level], colors=VERMILION, linewidths=1.8)
            for text in axes.clabel(line, fontsize=8, fmt=name):
                text.set_path_effects([withStroke(linewidth=2.5, foreground="white")])


def _scale(axis: Axis, set_scale: Callable[[str], None], values: np.ndarray) -> None:
    """Logarithmic where the values are evenly spaced so; turned round where they fall, so that the order is kept."""
    if len(values) > 2 and np.all(values > 0) and np.ptp(np.diff(np.log(values))) < 1e-6:
        set_scale("log")
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter(FormatStrFormatter("%g"))
        axis.set_minor_formatter(NullFormatter())
    if values[0] > values[-1]:
        axis.set_inverted(True)
