"""The figure of a response: what the cell did over a clip."""

import os
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.ticker import EngFormatter, MaxNLocator

from lgmd2jax._channels import Description
from lgmd2jax._figures.style import BLACK, BLUE, GREEN, SKY, VERMILION, drawn
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._video.snapshots import Snapshot
from lgmd2jax._video.trace import Trace


def response_figure(
    path: str | os.PathLike, trace: Trace, model: AbstractNetwork, snapshots: Sequence[Snapshot], title: str
) -> None:
    """What the cell did over a clip: snapshots, SMP and spikes with their thresholds, MP, FFI with its own, alarms."""
    time, levels = trace.time_ms / 1000, model.levels
    with drawn(path, 10, 7.6) as figure:
        figure.suptitle(title)
        grid = figure.add_gridspec(5, 1, height_ratios=(1.0, 2.6, 0.55, 1.3, 1.3))
        _strip(figure, grid[0], snapshots)
        smp = figure.add_subplot(grid[1])
        spikes, mp, ffi = (figure.add_subplot(grid[row], sharex=smp) for row in (2, 3, 4))
        for axes in (smp, spikes, mp):
            axes.tick_params(labelbottom=False)

        smp.plot(time, trace.smp, color=SKY, linewidth=1, label="before adaptation")
        smp.plot(time, trace.smp_adapted, color=BLUE, linewidth=1.6, label="after adaptation")
        for name, level in levels.by_count.items():
            _threshold(smp, level, name, VERMILION)
        smp.set(ylabel="SMP", ylim=(0.48, max(1.09, levels.spikes[-1] + 0.09)), yticks=np.linspace(0.5, 1, 6))

        spikes.vlines(time, 0, trace.spikes, color=BLACK, linewidth=1)
        spikes.set(ylabel="spikes", ylim=(0, len(levels.spikes) + 0.3), yticks=range(len(levels.spikes) + 1))

        mp.plot(time, trace.mp, color=BLACK)
        mp.set(ylabel=_label(model.channels["mp"]), ylim=(0, None))
        mp.yaxis.set_major_formatter(EngFormatter(sep=""))

        ffi.plot(time, trace.ffi, color=GREEN)
        inhibited = trace.ffi > levels.ffi
        ffi.fill_between(
            time,
            levels.ffi,
            trace.ffi,
            where=inhibited,
            interpolate=True,
            color=GREEN,
            alpha=0.35,
            label="cell inhibited",
        )
        if inhibited.any():
            ffi.legend(loc="upper left")
        _threshold(ffi, levels.ffi, levels.inhibited_from, GREEN)
        # A gate that is far away, or taken out, does not flatten the curve.
        ffi.set(
            ylabel=_label(model.channels["ffi"]),
            ylim=(0, 1.15 * max(trace.ffi.max(), min(levels.ffi, 4 * trace.ffi.max()), 1e-3)),
        )
        ffi.set(xlabel="time (s)", xlim=(time[0], time[-1]))

        for axes in (smp, spikes, mp, ffi):
            for start, end in trace.alarms():
                until = time[min(end + 1, len(time) - 1)]
                axes.axvspan(time[start], until, color=VERMILION, alpha=0.22, linewidth=0, label="alarm")
        handles = dict(zip(*reversed(smp.get_legend_handles_labels()), strict=True))
        smp.legend(handles.values(), handles.keys(), loc="upper left", ncols=3)

        ticks = MaxNLocator(10, integer=True).tick_values(trace.frame[0], trace.frame[-1])
        ticks = [int(tick) for tick in ticks if trace.frame[0] <= tick <= trace.frame[-1]]
        frames = smp.secondary_xaxis("top")
        frames.set_xticks(np.interp(ticks, trace.frame, time), [str(tick) for tick in ticks])
        frames.set_xlabel("frame (triangles: the snapshots)")
        marks = [shot.time / 1000 for shot in snapshots]
        smp.plot(marks, np.ones(len(marks)), "v", transform=smp.get_xaxis_transform(), clip_on=False, color=BLACK)


def _strip(figure: Figure, place: SubplotSpec, snapshots: Sequence[Snapshot]) -> None:
    row = place.subgridspec(1, len(snapshots))
    for column, shot in enumerate(snapshots):
        axes = figure.add_subplot(row[column])
        axes.imshow(shot.picture)
        colour = VERMILION if shot.alarm else BLACK
        axes.set_title(f"{shot.frame} alarm" if shot.alarm else f"{shot.frame}", color=colour)
        axes.set(xticks=(), yticks=())
        for spine in axes.spines.values():
            spine.set(visible=True, color=colour, linewidth=2.5 if shot.alarm else 0.8)


def _label(channel: Description) -> str:
    return f"{channel.label}\n({channel.unit}s)" if channel.unit != "1" else channel.label.replace(", ", "\n")


def _threshold(axes: Axes, level: float, name: str, colour: str) -> None:
    """A dashed line with its name at its right end, outside of the panel."""
    axes.axhline(level, color=colour, linewidth=1, linestyle=(0, (5, 3)))
    axes.annotate(
        name,
        (1, level),
        (4, 0),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
        color=colour,
        fontsize=8,
        va="center",
        annotation_clip=True,
    )
