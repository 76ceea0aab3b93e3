"""The figure of the law of peak times: the lines of all animals, and their slopes with intervals."""

import os

import numpy as np
from matplotlib.axes import Axes

from lgmd2jax._figures.style import BLUE, GREY, drawn
from lgmd2jax._reports.interval import Interval
from lgmd2jax._trials.peak_line import LoomingEstimate, PeakTimes


def looming_figure(path: str | os.PathLike, law: LoomingEstimate) -> None:
    """Peak times over l/|v| with their lines; alpha, delta and threshold angle of each animal and of all."""
    rows = [*law.animals.items(), (f"all {len(law.animals)}", law.pooled)]
    with drawn(path, 10, max(3.6, 1.6 + 0.22 * len(rows))) as figure:
        lines, *others = figure.subplots(1, 4, width_ratios=(2, 1, 1, 1))
        for times in law.animals.values():
            _draw_line(lines, times, GREY, 0.8)
        _draw_line(lines, law.pooled, BLUE, 2.0)
        lines.set(xlabel="l/|v| (ms)", ylabel="peak before collision (ms)")
        lines.set_title(f"all: alpha {law.pooled.alpha}, r2 {law.pooled.r2:.3f}", loc="left")
        places = np.arange(len(rows))[::-1]
        for axes, field, label in zip(
            others,
            ("alpha", "delta_ms", "threshold_angle_deg"),
            ("alpha", "delta (ms)", "threshold angle (deg)"),
            strict=True,
        ):
            for place, (_, times) in zip(places, rows, strict=True):
                interval: Interval = getattr(times, field)
                colour = BLUE if place == 0 else GREY
                axes.plot([interval.low, interval.high], [place, place], color=colour)
                axes.plot(interval.value, place, "o", color=colour, markersize=4)
            if field == "threshold_angle_deg":
                axes.set_xlim(0, 90)
            axes.set(xlabel=label, yticks=places, yticklabels=[name for name, _ in rows] if axes is others[0] else [])


def _draw_line(axes: Axes, times: PeakTimes, colour: str, width: float) -> None:
    speeds = np.array(list(times.peak_ms))
    axes.plot(speeds, [-peak for peak in times.peak_ms.values()], "o", color=colour, markersize=3)
    axes.plot(speeds, times.alpha.value * speeds - times.delta_ms.value, color=colour, linewidth=width)
