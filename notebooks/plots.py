"""The pictures of the notebooks, in the style of the library's figures. Each function draws one kind."""

import io
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray
from IPython.display import Image
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image as Picture

from lgmd2jax import Condition, Fit, LoomingLaw, Stimulus
from lgmd2jax._figures.arena import trajectories_figure
from lgmd2jax._figures.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, STYLE, VERMILION
from lgmd2jax._figures.sweep import surface_figure
from lgmd2jax.arena import Layout, Trip
from lgmd2jax.fitting._curve import variance_explained
from notebooks.paper_claims import Seen

COLOURS = {"LGMD2": BLUE, "LGMD1": VERMILION}
ORDERED = (SKY, BLUE, GREEN, ORANGE, VERMILION, PURPLE, BLACK)  # for conditions in an order
WIDTH = 7.0  # inches: a column
_DPI = 80


def drawn(figure: Figure) -> Image:
    """The figure as the picture that a cell shows, in few colours, so that notebooks stay small."""
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=_DPI)
    return _small(Picture.open(content).convert("RGB").quantize(64))


def _small(picture: Picture.Image) -> Image:
    content = io.BytesIO()
    picture.save(content, format="png", optimize=True)
    return Image(content.getvalue())


def panels(rows: int, cols: int, height: float, **options) -> tuple[Figure, np.ndarray]:
    """An empty figure of one column's width with its panels, `height` inches a row."""
    figure = Figure(figsize=(WIDTH, height * rows), layout="constrained")
    return figure, figure.subplots(rows, cols, squeeze=False, **options)


def smp_axes(axes: Axes, title: str, *levels: float) -> None:
    """Axes for a SMP, with spiking thresholds drawn."""
    for level in levels:
        axes.axhline(
            level,
            color=GREY,
            linewidth=0.9,
            linestyle=(0, (5, 3)),
            label="_" if level != levels[0] else "spiking threshold",
        )
    axes.set(title=title, ylim=(0.47, 1.04), yticks=(0.5, 0.75, 1.0))


@style.context(STYLE)
def networks(runs: Mapping[str, Mapping[str, Seen]], T_sp: float, columns: int = 2) -> Image:
    """The SMP of several networks on the same axes, a panel a condition; below, what was shown over time."""
    rows = -(-len(runs) // columns)
    figure, grid = panels(2 * rows, columns, 1.15, sharex="col", height_ratios=[3, 1] * rows)
    for i, (condition, seen) in enumerate(runs.items()):
        smp, course = grid[2 * (i // columns) : 2 * (i // columns) + 2, i % columns]
        smp_axes(smp, condition, T_sp)
        for name, it in seen.items():
            smp.plot(it.time, it.smp_adapted[0], color=COLOURS[name], label=name)
        first = next(iter(seen.values()))
        label, values = first.course
        course.plot(first.time, values, color=BLACK, linewidth=1)
        course.set(ylabel=label.replace("_px", "\n(px)").replace("level", "grey\nlevel"))
        course.yaxis.label.set_fontsize(7)
        smp.tick_params(labelbottom=True)
    for axes in grid[0::2, 0]:
        axes.set_ylabel("SMP")
    for axes in grid[-1]:
        axes.set_xlabel("time (ms)")
    figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return drawn(figure)


@style.context(STYLE)
def repeats(runs: Mapping[str, Seen], levels: Sequence[float], T_ffi: float, title: str) -> Image:
    """SMP and FFI, mean over repeats, a colour a condition; beside them peaks and spikes with their spread."""
    figure = Figure(figsize=(WIDTH, 4.0), layout="constrained")
    grid = figure.subplots(2, 2, width_ratios=(2.2, 1))
    figure.suptitle(title, fontsize=10)
    smp_axes(grid[0, 0], "SMP after adaptation, mean over repeats", *levels)
    for colour, (name, it) in zip(ORDERED, runs.items(), strict=False):
        grid[0, 0].plot(it.time, it.smp_adapted.mean(axis=0), color=colour, label=name)
        grid[1, 0].plot(it.time, it.ffi.mean(axis=0), color=colour)
        for axes, mean, spread in (
            (grid[0, 1], it.peak(), it.spread()),
            (grid[1, 1], it.spike_counts.mean(), it.spike_counts.std()),
        ):
            axes.errorbar(name, mean, spread, fmt="o", color=colour, capsize=4)
    grid[1, 0].axhline(T_ffi, color=GREY, linewidth=0.9, linestyle=(0, (5, 3)))
    grid[1, 0].set(title="FFI (dashed: T_ffi)", ylabel="grey levels", xlabel="time (ms)", ylim=(0, None))
    smp_axes(grid[0, 1], "peak", *levels)
    most = max(it.spike_counts.max() for it in runs.values())
    grid[1, 1].set(title="spikes", ylim=(0, max(1.2, 1.1 * most)))
    grid[0, 0].set_ylabel("SMP")
    for axes in grid[:, 1]:
        axes.margins(x=0.2)
        axes.tick_params(axis="x", labelrotation=25)
    grid[0, 0].legend(loc="upper left", fontsize=7)
    return drawn(figure)


@style.context(STYLE)
def adaptation(runs: Mapping[str, Seen], levels: Sequence[float], since_ms: float | None = None) -> Image:
    """SMP before and after SFA with spikes, a panel a condition, as the paper draws its robot's: the first repeat."""
    columns = {1: 1, 2: 2, 4: 2}.get(len(runs), 3)
    figure, grid = panels(-(-len(runs) // columns), columns, 1.9, sharey=True)
    for axes, (name, it) in zip(grid.flat, runs.items(), strict=True):
        smp_axes(axes, name, *levels)
        axes.plot(it.time, it.smp[0], color=VERMILION, linestyle="--", label="before SFA")
        axes.plot(it.time, it.smp_adapted[0], color=BLUE, label="after SFA")
        for count, label, colour in ((1, "1 spike", GREY), (2, "2 spikes", BLACK)):
            when = it.time[np.round(it.spikes[0]) == count]
            axes.plot(when, np.full(len(when), 0.48), "*", color=colour, markersize=4, label=label)
    for axes in grid[:, 0]:
        axes.set_ylabel("SMP")
    for axes in grid[-1]:
        axes.set_xlabel("time (ms)")
    for axes in grid.flat:
        axes.set_xlim(left=since_ms)
    figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=5, fontsize=7)
    return drawn(figure)


@style.context(STYLE)
def by_contrast(peaks: np.ndarray, contrasts: Sequence[float], speeds: Sequence[float], T_sp: float) -> Image:
    """Peak SMP over contrast, a line a speed."""
    figure, grid = panels(1, 1, 2.6)
    axes = grid[0, 0]
    smp_axes(axes, "peak SMP of the LGMD2 (dashed: spiking threshold)", T_sp)
    for colour, speed, column in zip(ORDERED, speeds, peaks.T, strict=False):
        axes.plot(contrasts, column, "o-", color=colour, label=f"{speed:g} px/s")
    axes.set(xlabel="contrast of a dark square, -Weber", ylabel="SMP", xticks=contrasts)
    axes.legend(title="edge", loc="lower right")
    return drawn(figure)


def surface(
    found: xarray.Dataset, value: str, title: str, thresholds: Mapping[str, float] | None = None, index: str = ""
) -> Image:
    """The figure that `lgmd2jax sweep` writes, for a column."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "surface.png")
        surface_figure(path, found, value, index or None, thresholds or {}, title)
        with Picture.open(path) as picture:
            size = 800, round(800 * picture.height / picture.width)
            return _small(picture.convert("RGB").resize(size).quantize(256, Picture.Quantize.FASTOCTREE))


def trajectories(layouts: Sequence[Layout], trips: Trip, title: str) -> Image:
    """The figure that `lgmd2jax arena` draws, for a column."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "trajectories.png")
        trajectories_figure(path, layouts, trips, title)
        with Picture.open(path) as picture:
            size = 1000, round(1000 * picture.height / picture.width)
            return _small(picture.convert("RGB").resize(size).quantize(64, Picture.Quantize.FASTOCTREE))


@style.context(STYLE)
def gratings(runs: Mapping[str, Seen], T_sp: float) -> Image:
    """SMP while a grating moves and as it stops, a row of colour a grating."""
    figure, grid = panels(1, 1, 2.8)
    axes, time = grid[0, 0], next(iter(runs.values())).time / 1000
    mesh = axes.pcolormesh(
        time, range(len(runs)), np.stack([it.smp_adapted[0] for it in runs.values()]), vmin=0.5, vmax=1, cmap="cividis"
    )
    axes.set(title="SMP of the LGMD2 (moving from 0 to 6 s)", xlabel="time (s)", yticks=range(len(runs)))
    axes.set_yticklabels([name.removeprefix("grating ") for name in runs])
    axes.grid(visible=False)
    bar = figure.colorbar(mesh, ax=axes, label="SMP")
    bar.ax.axhline(T_sp, color=VERMILION)
    return drawn(figure)


@style.context(STYLE)
def strip(stimulus: Stimulus, at_ms: Sequence[float]) -> Image:
    """Frames of a clip."""
    figure, grid = panels(1, len(at_ms), 1.1)
    for axes, time in zip(grid[0], at_ms, strict=True):
        axes.imshow(stimulus.frames[int(np.searchsorted(stimulus.time, time - 1e-3))], cmap="gray", vmin=0, vmax=255)
        axes.set(title=f"{time:g} ms", xticks=(), yticks=())
    return drawn(figure)


@style.context(STYLE)
def maps(pictures: Mapping[str, np.ndarray]) -> Image:
    """Layers of the network as pictures: grey levels as they are, the others with 0 in white."""
    figure, grid = panels(-(-len(pictures) // 3), 3, 1.7)
    for axes, (name, picture) in zip(grid.flat, pictures.items(), strict=True):
        plain = picture.min() >= 0
        limit = np.abs(picture).max() or 1
        shade = (
            {"cmap": "gray", "vmin": 0, "vmax": 255}
            if name == "frame"
            else {"cmap": "RdBu_r", "vmin": -limit, "vmax": limit}
        )
        drawn_map = axes.imshow(picture, **shade)
        axes.set(title=name, xticks=(), yticks=())
        if name != "frame":
            bar = figure.colorbar(drawn_map, ax=axes, shrink=0.8, label="grey levels")
            bar.ax.set_ylim(0 if plain else -limit, limit)
    return drawn(figure)


@style.context(STYLE)
def pictures(shots: Mapping[str, np.ndarray]) -> Image:
    """Pictures side by side."""
    figure, grid = panels(1, len(shots), 1.5)
    for axes, (name, shot) in zip(grid[0], shots.items(), strict=True):
        axes.imshow(shot)
        axes.set(title=name, xticks=(), yticks=())
    return drawn(figure)


@style.context(STYLE)
def targets(conditions: Sequence[Condition], law: LoomingLaw) -> Image:
    """Recorded rates with their standard errors, and a law."""
    figure, grid = panels(1, len(conditions), 2.2, sharey=True)
    for axes, condition in zip(grid[0], conditions, strict=True):
        stimulus = condition.render()
        recorded = condition.targets[0].on(stimulus)
        axes.plot(stimulus.time, recorded.values, color=BLACK, label="recorded")
        axes.plot(stimulus.time, law.on(stimulus).values, color=ORANGE, label="law")
        axes.set(
            title=condition.name.removeprefix("dark approach "), xlabel="time (ms)", xlim=(-300, 300), ylim=(0, 130)
        )
    grid[0, 0].set_ylabel("spikes/s")
    grid[0, 0].legend(loc="upper left")
    return drawn(figure)


@style.context(STYLE)
def fitted(fit: Fit, conditions: Sequence[Condition], left_out: Condition) -> Image:
    """Recorded rates and what the fitted hard model gives."""
    figure, grid = panels(1, len(conditions), 2.2, sharey=True)
    for axes, condition in zip(grid[0], conditions, strict=True):
        stimulus, new = condition.render(), condition is left_out
        recorded, model = condition.targets[0].on(stimulus), fit.predict(stimulus)
        explained = variance_explained(recorded.values, model, recorded.weight)
        axes.plot(stimulus.time, recorded.values, color=BLACK, label="recorded")
        axes.plot(stimulus.time, model, color=VERMILION if new else BLUE, label="predicted" if new else "fitted")
        name = condition.name.removeprefix("dark approach ")
        axes.set(title=f"{name}, R2 {explained:.3f}", xlabel="time (ms)", xlim=(-300, 300), ylim=(0, 130))
        axes.legend(loc="upper left", fontsize=7)
    grid[0, 0].set_ylabel("spikes/s")
    return drawn(figure)
