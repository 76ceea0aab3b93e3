"""The law of peak times from recorded trials: t_c - t_peak = alpha l/|v| - delta, with intervals by bootstrap."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from lgmd2jax._reports.interval import Interval
from lgmd2jax._signals import line_through, peak_times
from lgmd2jax._trials.quality import PEAK_RULE, RULE, Excluded, Rates, judged
from lgmd2jax._trials.trial import Trial

_CONFIDENCE = 0.95
_LEAST_R2 = 0.5  # below that a line leaves more unexplained than it explains


@dataclasses.dataclass(frozen=True)
class PeakTimes:
    """A line of peak times.

    - `alpha`, `delta_ms`: slope and delay of t_c - t_peak = alpha l/|v| - delta. A screen or a sound card that is late
      makes delta larger by its latency, and leaves alpha.
    - `threshold_angle_deg`: 2 atan(1/alpha), the full angle of the object delta before the peak.
    - `r2`: of the line. `trials`: how many it is made of.
    - `peak_ms`: time of the peak from collision, in ms, by l/|v|.
    """

    alpha: Interval
    delta_ms: Interval
    threshold_angle_deg: Interval
    r2: float
    trials: int
    peak_ms: Mapping[float, float]

    def plain(self) -> dict[str, Any]:
        """The numbers as plain data for JSON."""
        intervals = {name: getattr(self, name)._asdict() for name in ("alpha", "delta_ms", "threshold_angle_deg")}
        return vars(self) | intervals | {"peak_ms": {f"{speed:g}": peak for speed, peak in self.peak_ms.items()}}


@dataclasses.dataclass(frozen=True, repr=False)
class LoomingEstimate:
    """The law of peak times for each animal, and for all of them.

    - `pooled`: the slope that all animals share, each with a delta of its own; delta is the mean of theirs. Its
      intervals are of animals and trials drawn anew; those of an animal are of its trials drawn anew.
    - `animals`: by their names. `excluded`: what was left out by the `rule`, and why.
    - `kernel_ms`, `resamples`, `seed`: as they were asked for; `kernel_ms` is None for peaks by `PEAK_RULE`.
    """

    pooled: PeakTimes
    animals: Mapping[str, PeakTimes]
    excluded: tuple[Excluded, ...]
    kernel_ms: float | None
    resamples: int
    seed: int
    rule: str = RULE

    @property
    def peak_rule(self) -> str:
        """How a peak was timed."""
        return PEAK_RULE if self.kernel_ms is None else f"peaks are those of a Gaussian of {self.kernel_ms:g} ms"

    def __repr__(self):
        return self.summary()

    def plain(self) -> dict[str, Any]:
        """The numbers as plain data for JSON."""
        return {
            "pooled": self.pooled.plain() | {"animals": len(self.animals)},
            "animals": {name: times.plain() for name, times in self.animals.items()},
            "excluded": [dataclasses.asdict(item) for item in self.excluded],
            "rule": self.rule,
            "peak_rule": self.peak_rule,
            "kernel_ms": self.kernel_ms,
            "confidence": _CONFIDENCE,
            "resamples": self.resamples,
            "seed": self.seed,
        }

    def summary(self) -> str:
        """A table with a row an animal and one of all, what was left out by which rule, and whose line is none."""
        rows = [("", "alpha", "delta (ms)", "threshold angle (deg)", "r2", "trials")]
        for name, times in [*self.animals.items(), (f"all {len(self.animals)}", self.pooled)]:
            angle = str(times.threshold_angle_deg)
            rows.append((name, str(times.alpha), str(times.delta_ms), angle, f"{times.r2:.3f}", str(times.trials)))
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
        lines += ["", f"{self.peak_rule}; 95 % intervals: {self.resamples} bootstrap samples", f"rule: {self.rule}"]
        weak = [
            f"hardly a line: {name}: l/|v| explains {times.r2:.0%} of the variance of its peak times (r2), so neither "
            "its alpha nor its delta says much"
            for name, times in self.animals.items()
            if times.r2 < _LEAST_R2
        ]
        return "\n".join([*lines, *(f"left out: {item}" for item in self.excluded), *weak])


def estimate(trials: Sequence[Trial], kernel_ms: float | None, resamples: int, seed: int) -> LoomingEstimate:
    """The line of each animal that passes `RULE`, and of all.

    **Raises:** `ValueError` for what the settings cannot be, and where no animal is left.
    """
    if resamples < 2:
        raise ValueError(f"resamples is {resamples}; give at least 2")
    if seed < 0:
        raise ValueError(f"seed is {seed}; give 0 or more")
    passed, excluded = judged(trials, kernel_ms)
    if not passed:
        raise ValueError("no animal has a line of peak times; " + "; ".join(map(str, excluded)))
    rng = np.random.default_rng(seed)
    by_animal = {animal: [] for animal in dict.fromkeys(rates.animal for rates in passed)}
    for rates in passed:
        by_animal[rates.animal].append(rates)
    peaks = {animal: _peaks(own, resamples, rng) for animal, own in by_animal.items()}
    lines = {animal: _line(own) for animal, own in peaks.items()}
    return LoomingEstimate(_pooled(list(peaks.values()), rng), lines, tuple(excluded), kernel_ms, resamples, seed)


@dataclasses.dataclass(frozen=True)
class _Peaks:
    """The peak times of one animal, in ms before collision.

    `recorded` has one for each l/|v| of `speeds`, `drawn` a row of them for each bootstrap sample of the trials.
    """

    speeds: Float[np.ndarray, " speed"]
    recorded: Float[np.ndarray, " speed"]
    drawn: Float[np.ndarray, "sample speed"]
    trials: int

    @property
    def spread(self) -> Float[np.ndarray, " speed"]:
        """The speeds about their mean."""
        return self.speeds - self.speeds.mean()


def _peaks(rates: Sequence[Rates], resamples: int, rng: np.random.Generator) -> _Peaks:
    drawn = []
    for own in rates:
        count = len(own.rates)
        draws = max(
            count - 1, 1
        )  # one less than there are: means of so many vary as much as those of other trials would
        weights = rng.multinomial(draws, np.full(count, 1 / count), size=resamples) / draws
        drawn.append(-peak_times(own.time, weights @ own.rates))
    return _Peaks(
        np.array([own.l_over_v for own in rates]),
        np.concatenate([-peak_times(own.time, own.rates.mean(axis=0, keepdims=True)) for own in rates]),
        np.stack(drawn, axis=1),
        sum(len(own.rates) for own in rates),
    )


def _line(peaks: _Peaks) -> PeakTimes:
    """The line of one animal."""
    slope, intercept, _ = line_through(peaks.recorded, peaks.speeds)
    slopes = peaks.drawn @ peaks.spread / np.sum(peaks.spread**2)
    intercepts = peaks.drawn.mean(axis=1) - slopes * peaks.speeds.mean()
    return _peak_times(
        np.array([slope, *slopes]), np.array([intercept, *intercepts]), peaks.speeds, peaks.recorded, peaks.trials
    )


def _pooled(animals: Sequence[_Peaks], rng: np.random.Generator) -> PeakTimes:
    """The line of all animals, each with a delta of its own; both they and their trials are drawn anew."""
    resamples, count = len(animals[0].drawn), len(animals)
    sxx = np.array([np.sum(own.spread**2) for own in animals])
    means = np.array([own.speeds.mean() for own in animals])
    values = [np.vstack([own.recorded, own.drawn]) for own in animals]  # the first row is as recorded
    sxy = np.array([rows @ own.spread for rows, own in zip(values, animals, strict=True)])
    heights = np.array([rows.mean(axis=1) for rows in values])
    who = np.vstack([np.arange(count), rng.integers(count, size=(resamples, count))])
    sample = np.vstack([np.zeros((1, count), int), rng.integers(1, resamples + 1, size=(resamples, count))])
    slopes = sxy[who, sample].sum(axis=1) / sxx[who].sum(axis=1)
    intercepts = np.mean(heights[who, sample] - slopes[:, None] * means[who], axis=1)
    speeds = np.unique(np.concatenate([own.speeds for own in animals]))
    # Animals that were shown other l/|v| have other deltas: each is moved to the mean of all before they are averaged.
    moved = [own.recorded - own.recorded.mean() + slopes[0] * own.speeds.mean() + intercepts[0] for own in animals]
    averages = [
        np.mean([peak for own, peaks in zip(animals, moved, strict=True) for peak in peaks[own.speeds == speed]])
        for speed in speeds
    ]
    return _peak_times(slopes, intercepts, speeds, np.array(averages), sum(own.trials for own in animals))


def _peak_times(
    slopes: Float[np.ndarray, " sample"],
    intercepts: Float[np.ndarray, " sample"],
    speeds: Float[np.ndarray, " speed"],
    peaks: Float[np.ndarray, " speed"],
    trials: int,
) -> PeakTimes:
    """What a line tells. The first slope and intercept are those as recorded, the others of bootstrap samples."""
    rest = peaks - slopes[0] * speeds - intercepts[0]
    scatter = np.sum((peaks - peaks.mean()) ** 2)
    return PeakTimes(
        _interval(slopes),
        _interval(-intercepts),
        _interval(np.degrees(2 * np.arctan2(1, slopes))),
        float(1 - np.sum(rest**2) / scatter) if scatter > 0 else 0.0,
        trials,
        dict(zip(speeds.tolist(), (-peaks).tolist(), strict=True)),
    )


def _interval(values: Float[np.ndarray, " sample"]) -> Interval:
    low, high = np.quantile(values[1:], [(1 - _CONFIDENCE) / 2, (1 + _CONFIDENCE) / 2])
    return Interval(float(values[0]), float(low), float(high))
