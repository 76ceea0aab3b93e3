"""Which properties exclude each other, as a picture."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


def pairs_figure(path: Path, held: Float[np.ndarray, "row row"], numbers: Sequence[int], names: Sequence[str]) -> None:
    """For each pair, how many properties the best model holds that holds both; a cross where no model does."""
    figure = Figure(figsize=(9.5, 6.2))
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    shown = np.where(held > 0, held, np.nan)
    image = axes.imshow(shown, cmap="cividis", vmin=np.nanmin(shown), vmax=np.nanmax(shown))
    for i, j in np.argwhere(held == 0):
        axes.text(j, i, "x", ha="center", va="center", fontsize=8)
    axes.set_xticks(range(len(numbers)), [str(it) for it in numbers], fontsize=7)
    axes.set_yticks(range(len(numbers)), [f"{name}  {it}" for it, name in zip(numbers, names, strict=True)], fontsize=7)
    axes.set_xlabel("response property")
    axes.tick_params(length=0)
    figure.colorbar(image, label="properties held by the best model that holds both", shrink=0.8)
    axes.set_title("x: no model of the search holds both", fontsize=9, loc="left")
    figure.savefig(path, dpi=120, bbox_inches="tight")
