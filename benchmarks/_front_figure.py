"""What the properties cost in curves: the models that no other one excels in both."""

from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

_ASKED_ROWS, _ASKED_R2 = 20, 0.93
_COLOURS = ("#0072b2", "#009e73", "#d55e00")


def front_figure(
    path: Path, held: Int[np.ndarray, " model"], r2: Float[np.ndarray, "model loom"], looms: tuple[int, ...]
) -> None:
    """R2 of each dark loom over the properties that a model holds, and where both would be as is asked.

    **Arguments:** `looms`: their l/|v| in ms.
    """
    figure = Figure(figsize=(6.4, 3.8))
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    order = np.argsort(held)
    for column, (loom, colour) in enumerate(zip(looms, _COLOURS, strict=True)):
        axes.plot(held[order], r2[order, column], "o-", color=colour, markersize=4, linewidth=1, label=f"{loom} ms")
    axes.add_patch(Rectangle((_ASKED_ROWS, _ASKED_R2), 2, 1 - _ASKED_R2, color="0.8", zorder=0))
    axes.annotate("asked", (21, _ASKED_R2), ha="center", va="top", fontsize=8, color="0.4")
    axes.set_xlabel("properties that hold, of 22")
    axes.set_ylabel("R² of the dark loom")
    axes.set_ylim(min(-0.05, float(r2.min()) - 0.05), 1.02)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(title="l/|v|", frameon=False, loc="lower left")
    figure.savefig(path, dpi=120, bbox_inches="tight")
