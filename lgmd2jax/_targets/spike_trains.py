"""From the spike times of single trials to a rate with its standard error."""

import dataclasses
import math
from collections.abc import Iterable, Sequence
from typing import Annotated, Any, Literal

import numpy as np
from jaxtyping import Array, Float
from scipy.special import ndtr
from typing_extensions import TypeAliasType

from lgmd2jax._arguments.checked import checked
from lgmd2jax._arguments.units import Duration, duration, times
from lgmd2jax._targets.clock import doubt, share_inside
from lgmd2jax._targets.gaussian_sum import gaussian_sum
from lgmd2jax._targets.target import Target
from lgmd2jax._words import nearest, warn
from lgmd2jax.stimuli import Stimulus

Trial = Sequence[float | int] | Array | np.ndarray
Trials = TypeAliasType(
    "Trials", Annotated[Sequence[Sequence[Trial]], "for each animal a list of trials, as [[[10, 20]]]"]
)
Likelihood = Literal["normal", "poisson"]

_COARSE = 10  # standard deviations of the kernel between two samples, from which spikes fall between them
_REFRACTORY_MS = 0.5  # spikes of a neuron do not follow each other faster
_POOLED = 4  # animals for which the dispersion counts that all times share
_RASTER = (0, 1)  # what a bin of a raster holds; no neuron fires thrice within these two ms
_HALF_A_SPIKE = 0.5  # Jeffreys' prior of a count: silence does not tell that the rate is 0 exactly


@checked
@dataclasses.dataclass(frozen=True)
class SpikeTrains:
    """Trials of spike times, which become a rate at the frames of whatever stimulus evoked them.

    **Arguments:**

    - `trials`: for each animal its trials, each an array of spike times in ms, on the clock of the stimulus; an empty
      array is a trial without spikes. Times with a unit of their own, such as a `neo.SpikeTrain`, are converted by it.
    - `kernel_ms`: standard deviation of the Gaussian that makes a rate of the spikes.
    - `likelihood`: `"normal"` compares the smoothed rate, averaged over trials and animals, by least squares;
      `"poisson"` the spikes themselves, counted in bins around the frames, as an inhomogeneous Poisson process around
      the predicted rate. An `Observation`'s `smoothing` is then no kernel, for counts have none, but the scatter of the
      neuron's response from trial to trial. All trials count alike, whichever animal they are of.
    - `animals`: their names, by default "1", "2", and so on.

    **Raises:** `ValueError` as `spike_rate`, for another likelihood, and for names that are not one an animal.
    """

    trials: Trials
    kernel_ms: Duration = 20.0
    likelihood: Likelihood = "normal"
    animals: Sequence[str] | None = dataclasses.field(default=None, compare=False)

    def __post_init__(self):
        object.__setattr__(self, "kernel_ms", _kernel(self.kernel_ms))
        object.__setattr__(self, "trials", _nested(self.trials))
        count = len(_animals(self.trials))
        names = [str(number) for number in range(1, count + 1)] if self.animals is None else list(self.animals)
        if len(names) != count or len(set(names)) < count:
            raise ValueError(f"animals is {names}; give {count} different names, one for each animal of the trials")
        object.__setattr__(self, "animals", tuple(names))

    @checked
    def on(self, stimulus: Stimulus) -> Target:
        """The target at the frames of the stimulus, all of which the recordings are taken to cover."""
        time = np.asarray(stimulus.time, dtype=float)
        if self.likelihood == "poisson":
            return spike_counts(self.trials, time, self.kernel_ms)
        return spike_rate(self.trials, time, self.kernel_ms).on(stimulus)

    @checked
    def of(self, animal: str) -> "SpikeTrains":
        """The trials of one animal.

        **Raises:** `ValueError` for a name that none has.
        """
        names = self.animals or ()
        if animal not in names:
            raise ValueError(f"no animal is named {animal!r}; choose {nearest(animal, names)}")
        return dataclasses.replace(self, trials=[self.trials[names.index(animal)]], animals=[animal])


@checked
def spike_rate(trials: Trials, time: Any, kernel_ms: Duration = 20.0) -> Target:
    """The firing rate: a Gaussian on every spike, mean over animals of the means over trials.

    The recordings are taken to reach over `time` and over all spikes, no further: kernels that overlap an end of it are
    scaled up by what is cut off, so that a steady rate is steady up to the ends.

    The standard error is that over animals, since trials of one animal are no independent draws; None for one animal.
    Few animals tell little of it, and nothing where all are silent. So it is drawn towards a modelled one, the variance
    of Poisson counts times the dispersion between animals that all times share (a quasi-Poisson model), which counts
    like four animals more; and it is no smaller than the Poisson error of the rate and half a spike.

    The kernel makes neighbouring samples alike: white noise behind a Gaussian of s.d. s has the autocorrelation
    exp(-t^2/(4 s^2)), whose integral, 2 sqrt(pi) s, is the span that makes one independent sample (71 ms for 20 ms).

    **Arguments:** `trials` and `kernel_ms` as of `SpikeTrains`; `time` in ms, where the rate is wanted.

    **Returns:** a target in the channel `"rate"`, spikes/s, that may be interpolated.

    **Raises:** `ValueError` for no animals, an animal without trials, spike times that are no finite numbers or none of
    which lies within `time`, a kernel that is not positive or far narrower than the distance of the samples, and times
    that do not increase. Warns of spike times that look like another unit.
    """
    kernel_ms, animals, time = _kernel(kernel_ms), _animals(_nested(trials)), times(time, "time")
    _check_sampling(time, kernel_ms)
    spikes = np.concatenate([trial for animal in animals for trial in animal])
    _check_clock(spikes, time)
    reach = np.concatenate([time, spikes])
    covered = _gaussian_within(time, reach.min(), reach.max(), kernel_ms)
    rates = np.stack([gaussian_sum(np.concatenate(animal), time, kernel_ms) / len(animal) for animal in animals])
    rates *= 1000 / (kernel_ms * math.sqrt(2 * math.pi)) / covered
    rate, sem, rule = np.mean(rates, axis=0), None, ""
    if len(animals) > 1:
        # What a spike/s of one long trial adds to the variance: the kernel's square, which is narrower by sqrt(2).
        narrow = _gaussian_within(time, reach.min(), reach.max(), kernel_ms / math.sqrt(2))
        variance = 1000 * narrow / (2 * math.sqrt(math.pi) * kernel_ms) / covered**2
        share = sum(1 / len(animal) for animal in animals) / len(animals) ** 2
        sem, rule = _standard_error(rates, variance * share)
    correlation_ms = 2 * math.sqrt(math.pi) * kernel_ms
    return Target("rate", rate, time=time, sem=sem, correlation_ms=correlation_ms, interpolate=True, sem_rule=rule)


def spike_counts(trials: Trials, time: Float[np.ndarray, " time"], kernel_ms: Duration = 20.0) -> Target:
    """The spikes of all trials in bins around times, as counts that a Poisson likelihood weighs.

    Each bin reaches half-way to its neighbours. The standard error of a bin, which is drawn and sets the scale of a
    search, is that of Poisson counts at the rate behind a Gaussian of `kernel_ms`, and half a spike.

    **Returns:** a target in the channel `"rate"` at these times, spikes/s, with its exposure.

    **Raises:** `ValueError` as `spike_rate`.
    """
    smooth = spike_rate(trials, time, kernel_ms)
    all_trials = [np.asarray(trial) for animal in _animals(_nested(trials)) for trial in animal]
    middles = (time[1:] + time[:-1]) / 2
    edges = np.concatenate([[2 * time[0] - middles[0]], middles, [2 * time[-1] - middles[-1]]])
    counts, _ = np.histogram(np.concatenate(all_trials), edges)
    exposure = len(all_trials) * np.diff(edges) / 1000
    half_a_spike = _HALF_A_SPIKE * 1000 / (len(all_trials) * smooth.correlation_ms)
    sem = np.sqrt((smooth.values + half_a_spike) / exposure)
    rule = "spikes counted in bins around the frames, and weighed by the likelihood of a Poisson process"
    return Target("rate", counts / exposure, time=time, sem=sem, sem_rule=rule, exposure=exposure)


def _standard_error(
    rates: Float[np.ndarray, "animal time"], per_rate: Float[np.ndarray, " time"]
) -> tuple[Float[np.ndarray, " time"], str]:
    """The standard error of the mean over animals, and in words how it arose.

    **Arguments:** `per_rate`: variance of the mean for each spike/s, were spikes those of a Poisson process.
    """
    count = len(rates)
    between = np.var(rates, axis=0, ddof=1) / count
    poisson = (np.mean(rates, axis=0) + _HALF_A_SPIKE * per_rate) * per_rate
    dispersion = max(1.0, float(between.sum() / poisson.sum()))
    drawn = ((count - 1) * between + _POOLED * dispersion * poisson) / (count - 1 + _POOLED)
    rule = (
        f"s.e.m. over {count} animals, drawn towards the Poisson error times a dispersion that all times share, and "
        "no smaller than the Poisson error"
    )
    return np.sqrt(np.maximum(drawn, poisson)), rule


def _gaussian_within(
    time: Float[np.ndarray, " time"], start: float, end: float, s: float
) -> Float[np.ndarray, " time"]:
    """The share of a Gaussian about each time that lies within a window."""
    return ndtr((end - time) / s) - ndtr((start - time) / s)


def _check_sampling(time: np.ndarray, kernel_ms: float) -> None:
    if time.size > 1 and 0 < _COARSE * kernel_ms < (apart := float(np.median(np.diff(time)))):
        raise ValueError(
            f"kernel_ms is {kernel_ms:g} ms and the samples are {apart:g} ms apart, so that most spikes fall between "
            "them; give the kernel in ms, not narrower than a frame"
        )


def _check_clock(spikes: np.ndarray, time: np.ndarray) -> None:
    """Refuse spikes none of which can belong to the stimulus, and warn of those that hardly can."""
    reason = doubt(spikes, float(time[0]), float(time[-1]), closest_ms=_REFRACTORY_MS)
    if not reason:
        return
    if share_inside(spikes, float(time[0]), float(time[-1])) == 0:
        raise ValueError(f"the spike times {reason}")
    warn(f"the spike times {reason}")


def _kernel(kernel_ms: Any) -> float | int:
    kernel_ms = duration(kernel_ms, "kernel_ms")
    if not (isinstance(kernel_ms, (int, float, np.number)) and math.isfinite(kernel_ms) and kernel_ms > 0):
        raise ValueError(f"kernel_ms is {kernel_ms!r} ms; give a positive number")
    return float(kernel_ms)


def _nested(trials: Any) -> Any:
    """Lists of what is given, so that an iterator is walked once; what is no nesting stays for `_animals` to refuse."""
    if _is_leaf(trials):
        return trials
    return [animal if _is_leaf(animal) else list(animal) for animal in trials]


def _animals(trials: Any) -> list[list[np.ndarray]]:
    if _is_leaf(trials):
        raise ValueError(f"trials is {trials!r:.40}; give for each animal a list of trials, as [[[10, 20]]]")
    if not len(trials):
        raise ValueError("trials is empty; give at least one animal with its trials")
    animals = []
    for number, animal in enumerate(trials):
        if _is_leaf(animal):
            raise ValueError(f"trials[{number}] is {animal!r:.40}; give an animal's trials as a list, as [[[10, 20]]]")
        if not len(animal):
            raise ValueError(f"trials[{number}] is empty; leave out an animal without trials")
        animals.append([_times(trial, f"trials[{number}][{place}]") for place, trial in enumerate(animal)])
    return animals


def _is_leaf(values: Any) -> bool:
    """Whether this cannot be a list of animals or trials: a number, a text, a table, a set without order."""
    if isinstance(values, (str, bytes, dict, set, frozenset)) or getattr(values, "ndim", 1) == 0:
        return True
    return not isinstance(values, Iterable)


def _times(trial: Any, name: str) -> np.ndarray:
    spikes = times(trial, name)
    if spikes.ndim != 1 or not np.all(np.isfinite(spikes)):
        raise ValueError(f"{name} is {' '.join(repr(trial).split()):.40}; give finite spike times in ms, one axis")
    if spikes.size > len(_RASTER) and np.isin(spikes, _RASTER).all():
        raise ValueError(f"{name} holds {spikes.size} times 0 or 1, as a raster does; give the spikes' times in ms")
    return spikes
