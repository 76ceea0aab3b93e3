"""The figure of fits to several animals: each parameter of each animal, and what holds over animals."""

import os

import numpy as np
from matplotlib import style
from matplotlib.axes import Axes

from lgmd2jax._figures.after_fit import new_figure, written
from lgmd2jax._figures.style import BLUE, GREY, STYLE, VERMILION
from lgmd2jax.fitting import AnimalFits

_COLUMNS = 4  # panels side by side, at most


def plot_animals(fits: AnimalFits, path: str | os.PathLike | None) -> Axes:
    """A panel a parameter: a row an animal, value and 95 % interval; below them the mean, in grey the spread."""
    names, animals, free = fits.free.names, list(fits), fits.free
    columns = min(len(names), _COLUMNS)
    rows = -(-len(names) // columns)
    with style.context(STYLE):
        figure = new_figure(path, 1.0 + 2.4 * columns, 0.5 + rows * (1.1 + 0.21 * (len(animals) + 1)))
        grid = figure.subplots(rows, columns, squeeze=False, sharey=True)
        places = np.arange(len(animals))
        for i, axes in zip(range(len(names)), grid.flat, strict=False):
            for place, fit in zip(places, fits.fits.values(), strict=True):
                u = fit.uncertainty
                colour = BLUE if u.determined[i] and not u.on_bound[i] else GREY
                axes.plot(u.values[i], place, "o", color=colour, markersize=4)
                if u.determined[i]:
                    axes.hlines(place, *u.intervals[i], color=colour, linewidth=1.3)
            each, parameter = fits.population[names[i]], free.parameters[i]
            if np.isfinite(each.mean):
                axes.axvspan(each.mean - each.spread, each.mean + each.spread, color=GREY, alpha=0.2, linewidth=0)
                axes.hlines(len(animals), *each.interval, color=VERMILION, linewidth=2)
                axes.plot(each.mean, len(animals), "D", color=VERMILION, markersize=5)
            unit = parameter.symbol.unit
            axes.set_xlabel(names[i] if unit == "1" else f"{names[i]} ({unit})")
            axes.set_yticks([*places, len(animals)], [*animals, "mean"])
            axes.set_ylim(len(animals) + 0.6, -0.6)
        for axes in grid.flat[len(names) :]:
            axes.remove()
        return written(figure, path)
