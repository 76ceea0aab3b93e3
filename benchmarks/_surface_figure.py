"""Threshold angles of circuits over contrast and speed, side by side, and one of them without inhibition."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.colors import Normalize

from lgmd2jax._figures.style import BLACK, BLUE, GREY, VERMILION, drawn

_ANGLES = Normalize(15, 60)  # degrees
_SPEEDS = (10.0, 20.0, 40.0, 80.0)  # ms, of which the course is shown
_CONTRAST, _WEAKEST = -0.9, -0.3  # of the courses; the weakest that is judged


class Surfaces(NamedTuple):
    """What a circuit answers to each loom.

    - `curves`: R over time. `time`: of its frames in ms, 0 the collision.
    - `angle`: threshold angle in degrees; NaN where the peak is below .05.
    - `peak`: the largest R during the motion. `fall`: ms from there to half of it.
    """

    curves: Float[np.ndarray, "contrast l_over_v time"]
    time: Float[np.ndarray, " time"]
    angle: Float[np.ndarray, "contrast l_over_v"]
    peak: Float[np.ndarray, "contrast l_over_v"]
    fall: Float[np.ndarray, "contrast l_over_v"]


def surface_figure(
    path: Path,
    surfaces: Mapping[str, Surfaces],
    contrasts: Float[np.ndarray, " contrast"],
    l_over_v: Float[np.ndarray, " l_over_v"],
    early: Float[np.ndarray, " l_over_v"],
) -> None:
    """A surface of angles for each circuit; below, courses of R of the last two.

    **Arguments:** `early`: up to when, in ms, the two answer the same small angles.
    """
    with drawn(path, 11, 6.6) as figure:
        grid = figure.add_gridspec(2, 1, height_ratios=(1.25, 1))
        above, below = grid[0].subgridspec(1, len(surfaces)), grid[1].subgridspec(1, len(_SPEEDS))
        tops = [figure.add_subplot(above[column]) for column in range(len(surfaces))]
        pictures = [
            _surface(axes, each.angle, contrasts, l_over_v) for axes, each in zip(tops, surfaces.values(), strict=True)
        ]
        for axes, name in zip(tops, surfaces, strict=True):
            axes.set(title=name, xlabel="l/|v| (ms)")
        tops[0].set_ylabel("Weber contrast")
        figure.colorbar(pictures[0], ax=tops, label="threshold angle (deg)", extend="both")
        row = int(np.argmin(np.abs(contrasts - _CONTRAST)))
        for column, speed in enumerate(_SPEEDS):
            axes, place = figure.add_subplot(below[column]), int(np.argmin(np.abs(l_over_v - speed)))
            for (name, each), colour in zip(list(surfaces.items())[-2:], (BLUE, VERMILION), strict=True):
                axes.plot(each.time, each.curves[row, place], color=colour, label=name)
            axes.axvline(early[place], color=GREY, linewidth=1, linestyle=(0, (4, 3)), label="20 degrees")
            title = f"Weber {contrasts[row]:g}, {l_over_v[place]:.3g} ms"
            axes.set(title=title, xlabel="time (ms)", xlim=(-8 * speed - 100, 300), ylim=(-0.05, 1.15))
        figure.axes[-len(_SPEEDS)].set_ylabel("R")
        figure.legend(*figure.axes[-1].get_legend_handles_labels(), loc="outside lower center", ncols=3)


def _surface(axes: Axes, angle, contrasts, l_over_v):
    """Colours and lines of equal angle; what is not answered stays white."""
    picture = axes.pcolormesh(
        l_over_v, contrasts, angle, cmap="viridis", norm=_ANGLES, shading="nearest", rasterized=True
    )
    lines = axes.contour(l_over_v, contrasts, angle, levels=np.arange(20, 61, 10), colors=BLACK, linewidths=0.7)
    axes.clabel(lines, fontsize=7, fmt="%g")
    axes.axhline(_WEAKEST, color=VERMILION, linewidth=1, linestyle=(0, (4, 3)))
    axes.set(xscale="log", ylim=(-1.025, -0.025))
    axes.set_xticks(_SPEEDS, [f"{value:g}" for value in _SPEEDS])
    axes.minorticks_off()
    axes.grid(False)
    return picture
