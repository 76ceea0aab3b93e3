"""The figure of recorded trials: rasters and rates, a column a condition."""

import os
from collections import Counter

import numpy as np
from matplotlib.axes import Axes

from lgmd2jax._figures.style import BLACK, BLUE, GREY, drawn
from lgmd2jax._targets.spike_trains import spike_rate
from lgmd2jax._trials.trial import Trial, told
from lgmd2jax._trials.trials import Trials

_STEP_MS = 5.0


def trials_figure(path: str | os.PathLike, trials: Trials, kernel_ms: float = 20.0) -> None:
    """Above a raster of each condition, a line a trial, by animals; below the rates of animals, and their mean."""
    conditions = trials.conditions
    with drawn(path, max(4.0, 2.6 * len(conditions)), 6) as figure:
        panels = figure.subplots(2, len(conditions), squeeze=False, sharex=True, height_ratios=(2, 1))
        for condition, (raster, rates) in zip(conditions, panels.T, strict=True):
            own = [trial for trial in trials if trial.condition == condition]
            raster.set_title(told(condition) or "all trials", loc="left")
            if rates is not panels[1, 0]:
                rates.sharey(panels[1, 0])  # before it draws, so that the common limits hold all curves
            _draw_raster(raster, own)
            _draw_rates(rates, own, kernel_ms)
            raster.invert_yaxis()
            rates.set_xlabel("time from event (ms)")
        panels[1, 0].set_ylabel("spikes/s")


def _draw_raster(axes: Axes, trials: list[Trial]) -> None:
    rows = np.repeat(np.arange(len(trials)), [trial.spikes_ms.size for trial in trials])
    spikes = np.concatenate([trial.spikes_ms for trial in trials])
    axes.plot(spikes, rows, "|", color=BLACK, markersize=2, markeredgewidth=0.4, rasterized=True)
    counts = Counter(trial.animal for trial in trials)
    heights = np.array(list(counts.values()))
    ends = np.cumsum(heights)
    for end in ends[:-1]:
        axes.axhline(end - 0.5, color=GREY, linewidth=0.5)
    axes.set_yticks(ends - heights / 2 - 0.5, list(counts))


def _draw_rates(axes: Axes, trials: list[Trial], kernel_ms: float) -> None:
    start, end = max(trial.start_ms for trial in trials), min(trial.end_ms for trial in trials)
    time = np.arange(start, end + _STEP_MS / 2, _STEP_MS)
    means = []
    for animal in dict.fromkeys(trial.animal for trial in trials):
        spikes = [trial.spikes_ms for trial in trials if trial.animal == animal]
        if not any(np.any((train >= start) & (train <= end)) for train in spikes):
            means.append(np.zeros(time.shape))
            continue
        means.append(spike_rate([spikes], time, kernel_ms).values)
        axes.plot(time, means[-1], color=GREY, linewidth=0.6)
    axes.plot(time, np.mean(means, axis=0), color=BLUE)
    axes.axvline(0, color=BLACK, linewidth=0.6)
