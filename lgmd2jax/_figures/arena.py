"""The figure of robots in arenas, from above, as the paper draws them."""

import os
from collections.abc import Sequence

import jax
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from lgmd2jax._figures.style import BLACK, BLUE, GREEN, ORANGE, VERMILION, drawn
from lgmd2jax.arena import Layout, Trip
from lgmd2jax.arena._layout import ROBOT_RADIUS_CM, SIDE_CM


def trajectories_figure(path: str | os.PathLike, layouts: Sequence[Layout], trips: Trip, title: str) -> None:
    """An arena beside the other: obstacles in red, the trajectory in blue, alarms, contacts, the start and the end.

    **Arguments:** `trips`: stacked as the layouts.
    """
    with drawn(path, 3.1 * len(layouts), 3.9) as figure:
        figure.suptitle(title)
        for number, axes in enumerate(np.atleast_1d(figure.subplots(1, len(layouts)))):
            _arena(axes, layouts[number], jax.tree.map(lambda leaf, own=number: np.asarray(leaf[own]), trips))
        marks = [
            Line2D([], [], color=BLUE, label="trajectory of the robot's centre"),
            Line2D([], [], color=BLUE, marker="o", markerfacecolor="none", linestyle="", label="start"),
            Line2D([], [], color=GREEN, marker="o", markerfacecolor="none", linestyle="", label="end"),
            Line2D([], [], color=ORANGE, marker=".", linestyle="", label="alarm"),
            Line2D([], [], color=BLACK, marker="x", linestyle="", label="contact"),
            Line2D([], [], color=VERMILION, marker="o", markerfacecolor="none", linestyle="", label="obstacle"),
        ]
        figure.legend(handles=marks, loc="outside lower center", ncols=len(marks))


def _arena(axes: Axes, layout: Layout, trip: Trip) -> None:
    obstacles = [Circle(centre, radius) for centre, radius in zip(layout.centres, layout.radii, strict=True)]
    axes.add_collection(PatchCollection(obstacles, facecolor="none", edgecolor=VERMILION, linewidth=1.5))
    x, y = trip.pose.place.T
    axes.plot(x, y, color=BLUE, linewidth=1)
    ends = [(Circle((x[frame], y[frame]), ROBOT_RADIUS_CM), colour) for frame, colour in ((0, BLUE), (-1, GREEN))]
    for circle, colour in ends:
        circle.set(facecolor="none", edgecolor=colour, linewidth=1.5)
        axes.add_patch(circle)
    axes.plot(x[trip.alarm], y[trip.alarm], ".", color=ORANGE, markersize=5)
    axes.plot(x[trip.contact], y[trip.contact], "x", color=BLACK, markersize=6)
    metres = float(trip.driven_cm.sum()) / 100
    axes.set_title(f"{metres:.1f} m, {int(trip.alarm.sum())} alarms, {int(trip.contact.sum())} contacts")
    axes.set(xlim=(0, SIDE_CM), ylim=(0, SIDE_CM), aspect="equal", xticks=(0, 55, 110), yticks=(0, 55, 110))
    axes.spines[["top", "right"]].set_visible(True)
    axes.grid(False)
    axes.set_xlabel("cm")
