"""From the spike times of single trials to a rate with its standard error."""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Array, Float
from scipy.special import ndtr

from lgmd2jax._targets.target import Target
from lgmd2jax.stimuli import Stimulus

Trial = Sequence[float | int] | Array | np.ndarray
Trials = Sequence[Sequence[Trial]]


@dataclasses.dataclass(frozen=True)
class SpikeTrains:
    """Trials of spike times, which become a rate at the frames of whatever stimulus evoked them.

    **Arguments:**

    - `trials`: for each animal its trials, each an array of spike times in ms, on the clock of the stimulus; an empty
      array is a trial without spikes.
    - `kernel_ms`: standard deviation of the Gaussian.

    **Raises:** `ValueError` as `spike_rate`.
    """

    trials: Trials
    kernel_ms: float | int = 20.0

    def __post_init__(self):
        _check(self.trials, self.kernel_ms)

    def on(self, stimulus: Stimulus) -> Target:
        """The target at the frames of the stimulus, all of which the recordings are taken to cover."""
        return spike_rate(self.trials, np.asarray(stimulus.time, dtype=float), self.kernel_ms).on(stimulus)


def spike_rate(trials: Trials, time: Float[np.ndarray, " time"], kernel_ms: float | int = 20.0) -> Target:
    """The firing rate: a Gaussian on every spike, mean over animals of the means over trials.

    The standard error is that over animals, since trials of one animal are no independent draws; None for one animal.
    The recordings are taken to reach over `time` and over all spikes, no further: kernels that overlap an end of it are
    scaled up by what is cut off, so that a steady rate is steady up to the ends.

    The kernel makes neighbouring samples alike: white noise behind a Gaussian of s.d. s has the autocorrelation
    exp(-t^2/(4 s^2)), whose integral, 2 sqrt(pi) s, is the span that makes one independent sample (71 ms for 20 ms).

    **Arguments:** `trials` and `kernel_ms` as of `SpikeTrains`; `time` in ms, where the rate is wanted.

    **Returns:** a target in the channel `"rate"`, spikes/s, that may be interpolated.

    **Raises:** `ValueError` for no animals, an animal without trials, spike times that are no finite numbers, a kernel
    that is not positive, and times that do not increase.
    """
    animals = _check(trials, kernel_ms)
    reach = np.concatenate([time, *(trial for animal in animals for trial in animal)])
    start, end = reach.min(), reach.max()
    seen = ndtr((end - time) / kernel_ms) - ndtr((start - time) / kernel_ms)
    rates = np.stack(
        [np.mean([_smooth(trial, time, kernel_ms) for trial in animal], axis=0) / seen for animal in animals]
    )
    sem = np.std(rates, axis=0, ddof=1) / math.sqrt(len(rates)) if len(rates) > 1 else None
    return Target(
        "rate",
        np.mean(rates, axis=0),
        time=time,
        sem=sem,
        correlation_ms=2 * math.sqrt(math.pi) * kernel_ms,
        interpolate=True,
    )


def _smooth(spikes: np.ndarray, time: np.ndarray, kernel_ms: float) -> np.ndarray:
    """Spikes/s of one trial, without regard to the ends."""
    kernel = np.exp(-0.5 * ((time[:, None] - spikes[None, :]) / kernel_ms) ** 2)
    return kernel.sum(axis=1) * 1000 / (kernel_ms * math.sqrt(2 * math.pi))


def _check(trials: Trials, kernel_ms: float) -> list[list[np.ndarray]]:
    if not (math.isfinite(kernel_ms) and kernel_ms > 0):
        raise ValueError(f"kernel_ms is {kernel_ms} ms; give a positive number")
    if not len(trials):
        raise ValueError("trials is empty; give at least one animal with its trials")
    animals = []
    for number, animal in enumerate(trials):
        if not len(animal):
            raise ValueError(f"trials[{number}] is empty; leave out an animal without trials")
        animals.append([_times(trial, f"trials[{number}][{place}]") for place, trial in enumerate(animal)])
    return animals


def _times(trial: Trial, name: str) -> np.ndarray:
    try:
        times = np.asarray(trial, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {trial!r:.40}; give spike times in ms") from None
    if times.ndim != 1 or not np.all(np.isfinite(times)):
        raise ValueError(f"{name} is {trial!r:.40}; give finite spike times in ms, one axis")
    return times
