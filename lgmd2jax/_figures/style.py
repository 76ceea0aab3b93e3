"""The one style of all figures, applied while a figure is drawn and nowhere else, without pyplot."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from matplotlib import style
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler

# Okabe & Ito's colours, which stay apart for colour-blind eyes. Each keeps its meaning in every figure.
BLACK, GREY = "#000000", "#8c8c8c"
BLUE, SKY, GREEN, ORANGE, VERMILION, PURPLE = "#0072B2", "#56B4E9", "#009E73", "#E69F00", "#D55E00", "#CC79A7"

# One of each for things side by side, as models or fits.
COLOURS, MARKS = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, BLACK), "os^Dv<>"

STYLE = {
    "agg.path.chunksize": 5000,  # points: a noisy curve drawn in one go takes 2 kB for each of them
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.labelsize": 9,
    "axes.prop_cycle": cycler(color=[BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY, BLACK]),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 9,
    "figure.dpi": 150,
    "figure.titlesize": 11,
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9,
    "grid.alpha": 0.25,
    "grid.linewidth": 0.5,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "savefig.dpi": 150,
    "svg.hashsalt": "lgmd2jax",
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
}


@contextlib.contextmanager
def drawn(path: str | os.PathLike, width: float | int, height: float | int) -> Iterator[Figure]:
    """An empty figure in the library's style, its size in inches, saved at `path` when the block ends.

    It is made without pyplot, so no window, no backend and no setting of the user's is touched.
    """
    with style.context(STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        yield figure
        if (layout := figure.get_layout_engine()) is not None:
            layout.execute(figure)  # else `savefig` would draw all twice, once for the layout alone
            figure.set_layout_engine(None)
        figure.savefig(path)


def check_figure_path(path: str | os.PathLike) -> None:
    """Raise `ValueError` for a name whose suffix is no format that a figure can be written in."""
    known = Figure().canvas.get_supported_filetypes()
    if Path(path).suffix[1:].lower() not in known:
        raise ValueError(f"cannot tell the format of the figure {path}; end its name in .png, .pdf or .svg")


def check_count(count: int, things: str) -> None:
    """Raise `ValueError` for more things side by side than there are colours."""
    if count > len(COLOURS):
        raise ValueError(f"{count} {things} are more than a figure keeps apart; give at most {len(COLOURS)}")
