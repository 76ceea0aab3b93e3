"""Which recordings show a response to the approach: the rate of each animal and l/|v|, and what is left out."""

import dataclasses
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.ndimage import gaussian_filter1d

from lgmd2jax._trials.trial import Trial

_HIGHEST_BASE = 20.0  # spikes/s
_TIMES_BASE, _ABOVE = 2.0, 20.0  # the peak must exceed so many times the base and so many spikes/s
_EARLIEST, _MARGIN_MS, _LATEST_MS = 10.0, 50.0, 200.0  # of a peak: in l/|v| and ms before collision, in ms after
_EDGE = 0.2  # of a trial, at either end, where the base is measured
_BIN_MS = 1.0
_KERNELS_MS = 1.0, 1000.0  # s.d. of a Gaussian that may be asked for
KERNEL_MS = 20.0  # of the Gaussian of the rates that are judged
_SHARE, _NARROWEST_MS = 1.4, 12.0  # s.d. of the Gaussian within the kernel of peak times: of l/|v|, and at least

RULE = (
    f"left out are sessions whose base rate, the lower of the mean rates in the first and last {_EDGE:.0%} of their "
    f"trials, is {_HIGHEST_BASE:g} spikes/s or more; an l/|v| of an animal where the peak of the mean rate is not "
    f"above {_TIMES_BASE:g} times the base plus {_ABOVE:g} spikes/s, or is earlier than {_EARLIEST:g} l/|v| + "
    f"{_MARGIN_MS:g} ms before collision or later than {_LATEST_MS:g} ms after; animals of whom fewer than two l/|v| "
    "are left"
)

PEAK_RULE = (
    f"peaks are those of a kernel of sixth order, 1 - (1 - G)^3 with a Gaussian G of {_SHARE:g} l/|v|, at "
    f"least {_NARROWEST_MS:g} ms: where an asymmetric rate widens with l/|v|, this changes alpha and leaves delta"
)


@dataclasses.dataclass(frozen=True)
class Excluded:
    """What is left out of the line of peak times, and why.

    **Arguments:** `l_over_v` in ms; None for all of the animal, or for sessions that the reason names.
    """

    animal: str
    reason: str
    l_over_v: float | None = None

    def __str__(self):
        speed = "" if self.l_over_v is None else f", l/|v| {self.l_over_v:g} ms"
        return f"{self.animal}{speed}: {self.reason}"


@dataclasses.dataclass(frozen=True)
class Rates:
    """Smoothed rates of all trials of an animal at one l/|v|, in spikes/s, where a peak may lie.

    `time` in ms from collision, in steps of 1 ms; `rates` has a row a trial. They are those by which a peak is timed.
    """

    animal: str
    l_over_v: float
    time: Float[np.ndarray, " time"]
    rates: Float[np.ndarray, "trial time"]


def judged(trials: Sequence[Trial], kernel_ms: float | None) -> tuple[list[Rates], list[Excluded]]:
    """The rates that pass `RULE`, by animal and l/|v|, and what does not.

    **Arguments:** `kernel_ms`: of a Gaussian; None: rates by `PEAK_RULE`.

    **Raises:** `ValueError` for a trial without a number as `l_over_v`.
    """
    with_line, _, excluded = _by_rule(trials, kernel_ms)
    return [rates for rates, _ in with_line], excluded


def accepted(trials: Sequence[Trial], kernel_ms: float | None) -> tuple[list[Trial], list[Excluded]]:
    """The trials that a fit can aim at: those of animals with a line or, where none has one, of all that answer.

    **Raises:** as `judged`.
    """
    with_line, others, excluded = _by_rule(trials, kernel_ms)
    if not with_line:
        alone = {rates.animal for rates, _ in others}
        excluded = [item for item in excluded if item.l_over_v is not None or item.animal not in alone]
    return [trial for _, own in with_line or others for trial in own], excluded


def noisy(trials: Sequence[Trial]) -> list[Trial]:
    """The trials whose own base rate is that of noise."""
    return [trial for trial in trials if base_rate([trial]) >= _HIGHEST_BASE]


_Passed = list[tuple[Rates, list[Trial]]]


def _by_rule(trials: Sequence[Trial], kernel_ms: float | None) -> tuple[_Passed, _Passed, list[Excluded]]:
    """What passes, of animals with two l/|v| or more and of those with one, and what does not."""
    _check_kernel(kernel_ms)
    excluded, left = [], []
    sessions = list(_groups(trials, lambda trial: (trial.animal, trial.session)))
    for animal in dict.fromkeys(animal for (animal, _), _ in sessions):
        noise = {}
        for (who, session), own in sessions:
            if who == animal and (base := base_rate(own)) >= _HIGHEST_BASE:
                noise[session] = base
            elif who == animal:
                left += own
        if noise:
            excluded.append(Excluded(animal, _told_noise(noise)))
    passed = []
    for (animal, speed), own in _groups(left, lambda trial: (trial.animal, l_over_v(trial))):
        rates, reason = _rates(animal, speed, own, kernel_ms)
        if reason:
            excluded.append(Excluded(animal, reason, l_over_v=speed))
        else:
            passed.append((rates, own))
    speeds = Counter(rates.animal for rates, _ in passed)
    with_line = [(rates, own) for rates, own in passed if speeds[rates.animal] > 1]
    others = [(rates, own) for rates, own in passed if speeds[rates.animal] == 1]
    for rates, _ in others:
        excluded.append(Excluded(rates.animal, f"one l/|v| is left, {rates.l_over_v:g} ms; a line needs two"))
    return with_line, others, excluded


def _check_kernel(kernel_ms: float | None) -> None:
    """Refuse a kernel that blurs no rate, such as one in seconds, or every one."""
    low, high = _KERNELS_MS
    if kernel_ms is not None and not low <= kernel_ms <= high:
        raise ValueError(
            f"kernel_ms is {kernel_ms:g}; give the s.d. of a Gaussian in ms, {low:g} to {high:g}, as 20, or None for a "
            "kernel that l/|v| sets"
        )


def l_over_v(trial: Trial) -> float:
    """l/|v| of a trial in ms.

    **Raises:** `ValueError` where its condition has none.
    """
    value = trial.condition.get("l_over_v")
    if not isinstance(value, float):
        raise ValueError(f"{trial} has no l/|v|; name its column, or give its value in ms, by l_over_v (--l-over-v)")
    return value


def base_rate(trials: Sequence[Trial]) -> float:
    """The lower of the mean rates, in spikes/s, in the first and in the last part of these trials."""
    rates = []
    for from_end in (False, True):
        count = span = 0.0
        for trial in trials:
            edge = _EDGE * (trial.end_ms - trial.start_ms)
            at = trial.spikes_ms
            count += np.sum(at >= trial.end_ms - edge if from_end else at < trial.start_ms + edge)
            span += edge
        rates.append(1000 * count / span)
    return float(min(rates))


def _rates(animal: str, speed: float, trials: Sequence[Trial], kernel_ms: float | None) -> tuple[Rates, str]:
    """The rates where a peak may lie, and what speaks against them."""
    start, end = max(trial.start_ms for trial in trials), min(trial.end_ms for trial in trials)
    edges = np.arange(np.ceil(start), np.floor(end) + _BIN_MS / 2, _BIN_MS)
    if edges.size < 2:
        return Rates(animal, speed, edges[:0], np.zeros((len(trials), 0))), "there is no time that all trials recorded"
    counts = np.stack([np.histogram(trial.spikes_ms, edges)[0] for trial in trials])
    rates = _smooth(1000 / _BIN_MS * counts, kernel_ms or KERNEL_MS)
    time, mean, base = edges[:-1] + _BIN_MS / 2, rates.mean(axis=0), base_rate(trials)
    peak, needed = float(mean.max()), _TIMES_BASE * base + _ABOVE
    earliest = -_EARLIEST * speed - _MARGIN_MS
    inside = (time >= earliest) & (time <= _LATEST_MS)
    at = time[mean.argmax()]
    reason = ""
    if peak <= needed:
        reason = f"peak {peak:.1f} spikes/s, not above {needed:.1f} at a base of {base:.1f}"
    elif not earliest <= at <= _LATEST_MS:
        reason = f"peak at {at:.0f} ms, not within {earliest:g} to {_LATEST_MS:g} ms from collision"
    if kernel_ms is None:
        rates = _without_lag(1000 / _BIN_MS * counts, max(_SHARE * speed, _NARROWEST_MS))
    return Rates(animal, speed, time[inside], rates[:, inside]), reason


def _smooth(counts: Float[np.ndarray, "trial time"], kernel_ms: float) -> Float[np.ndarray, "trial time"]:
    return gaussian_filter1d(counts, kernel_ms / _BIN_MS, axis=1, mode="constant")


def _without_lag(counts: Float[np.ndarray, "trial time"], kernel_ms: float) -> Float[np.ndarray, "trial time"]:
    """Rates by the kernel 1 - (1 - G)^3 of a Gaussian G, of sixth order: polynomials up to t^5 stay as they are.

    A Gaussian moves the peak of a rate that rises more slowly than it falls towards the rise, by its variance times the
    third derivative over the second one. This kernel's bias begins with the seventh derivative. It widens as l/|v|
    does, as a response to a looming object does, so that the bias that is left belongs to alpha and not to delta.
    """
    rest = counts
    for _ in range(3):
        rest = rest - _smooth(rest, kernel_ms)
    return counts - rest


def _told_noise(bases: Mapping[str, float]) -> str:
    """The base rates of the sessions that fall out."""
    low, high = f"{min(bases.values()):.1f}", f"{max(bases.values()):.1f}"
    rates = low if low == high else f"{low} to {high}"
    where = "" if set(bases) == {""} else f" in session {', '.join(bases)}"
    return f"base rate {rates} spikes/s{where}, as of noise"


def _groups(trials: Sequence[Trial], key: Callable[[Trial], Any]) -> Iterator[tuple[Any, list[Trial]]]:
    """The trials that share a key, in the order of their keys' first trials."""
    groups: dict[Any, list[Trial]] = {}
    for trial in trials:
        groups.setdefault(key(trial), []).append(trial)
    yield from groups.items()
