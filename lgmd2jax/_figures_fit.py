"""The figure of a fit: target, soft and hard in every condition."""

from pathlib import Path

from lgmd2jax._figures import BLACK, BLUE, GREY, VERMILION, drawn
from lgmd2jax._recipe import Curves


def fit_figure(path: Path, curves: list[Curves], name: str) -> None:
    """A panel a condition: the recorded rate with its standard error, the soft model, and the one handed over."""
    columns = min(len(curves), 3)
    rows = -(-len(curves) // columns)
    with drawn(path, max(6.5, 3.6 * columns), 0.6 + 3.4 * rows) as figure:
        figure.suptitle(f"Fit {name}: what the handed-over model makes of the recording")
        panels = figure.subplots(rows, columns, squeeze=False, sharey=True)
        for axes, curve in zip(panels.flat, curves, strict=False):
            values, sem = curve.target.values, curve.target.sem
            if sem is not None:
                axes.fill_between(curve.time, values - sem, values + sem, color=GREY, alpha=0.35, linewidth=0)
            axes.plot(curve.time, values, color=BLACK, linewidth=2, label="recorded, mean and s.e.m.")
            axes.plot(curve.time, curve.soft, color=BLUE, label=f"soft, R² {curve.r2['soft']:.3f}")
            axes.plot(
                curve.time,
                curve.hard,
                color=VERMILION,
                linestyle="--",
                label=f"hard, handed over, R² {curve.r2['hard']:.3f}",
            )
            axes.axvline(0, color=GREY, linewidth=0.8)
            axes.set(title=curve.name, xlabel="time from collision (ms)")
            axes.legend(loc="upper left")
        for axes in panels[:, 0]:
            axes.set_ylabel("firing rate (spikes/s)")
        for axes in panels.flat[len(curves) :]:
            axes.remove()
