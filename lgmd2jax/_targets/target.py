"""The curve or band that a response is compared with, and what a difference from it weighs."""

import dataclasses
from functools import partial
from typing import Any, Protocol, runtime_checkable

import equinox as eqx
import numpy as np
from jaxtyping import Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._arguments.units import duration, levels, times
from lgmd2jax._channels import Channel
from lgmd2jax._targets.clock import doubt, share_inside
from lgmd2jax.stimuli import Stimulus

_OFF_FRAME = 0.01  # of a frame, by which times may miss the frames: what rounding in a CSV file does
_LEAST_SEM = 0.1  # of the r.m.s. of recorded standard errors: what few recordings show below it is chance


@runtime_checkable
class AnyTarget(Protocol):
    """What becomes a target once the stimulus is known. A `Target` is one itself."""

    def on(self, stimulus: Stimulus) -> "Target":
        """The target at the frames of the stimulus."""
        ...


def _optional(values: Any, name: str) -> np.ndarray | None:
    return None if values is None else levels(values, name)


def _optional_times(values: Any) -> np.ndarray | None:
    return None if values is None else times(values, "time")


def _duration(value: Any) -> Any:
    return duration(value, "correlation_ms")


@checked
class Target(eqx.Module):
    """A curve over time in one channel of the response, or a band in which the response should lie.

    Numbers with a unit of their own, as quantities, pint, pandas or xarray give them, are converted by it.

    **Arguments:**

    - `channel`: `"smp"`, `"smp_adapted"`, `"spikes"` (a frame), or `"rate"` (spikes/s, through an `Observation`).
    - `values`: in the unit of the channel.
    - `time`: of the values, in ms; None where they stand at the frames of the stimulus.
    - `sem`: standard error of each value, where it was recorded. It is drawn, and it is the `error` where none is
      given. One that is tiny, 0 for example, is an accident of few recordings: where there is no `sem_rule`, each
      counts as at least a tenth of the r.m.s. of all standard errors.
    - `error`: standard error by which a difference is divided, one number or one for each value.
    - `weight`: factor of the squared difference, one number or one for each value; 0 for what does not count.
    - `correlation_ms`: the span that makes one independent sample: 2 sqrt(pi) s behind a Gaussian of s.d. s.
    - `interpolate`: whether values at other times than the frames' may be interpolated onto these. That makes no new
      samples: of values that lie further apart than the frames each counts once, at the frame nearest to it.
    - `sem_rule`: how the standard errors arose, for the report of a fit.
    - `upper`: makes the target a band, of which `values` are the lower edge and these the upper one. A response within
      costs nothing, edges included; one outside differs by its distance from the nearer edge. One edge may be infinite.
    - `quote`: the words of a paper that the target stands for; a report counts all targets of the same words together.
    - `exposure`: makes the values, at the frames of the stimulus, counts of spikes by the time in which they were
      counted, in s, all trials together. A difference is then weighed by the Poisson likelihood of the counts, and
      `sem` is only drawn.

    **Raises:** `ValueError` for an unknown channel, for arrays of unequal lengths, for what is not finite, for times
    that do not increase, for negative errors and weights, and for a band with an edge above the other, without any
    finite edge, or with a `sem`, which only a curve has, and for an exposure of another channel than the rate.
    """

    channel: Channel = eqx.field(static=True)
    values: Float[np.ndarray, " time"] = eqx.field(converter=partial(levels, name="values"))
    time: Float[np.ndarray, " time"] | None = eqx.field(default=None, converter=_optional_times)
    sem: Float[np.ndarray, " time"] | None = eqx.field(default=None, converter=partial(_optional, name="sem"))
    error: Float[np.ndarray, " *#time"] | None = eqx.field(default=None, converter=partial(_optional, name="error"))
    weight: Float[np.ndarray, " *#time"] = eqx.field(default=1.0, converter=partial(levels, name="weight"))
    correlation_ms: float | int = eqx.field(default=0.0, static=True, converter=_duration)
    interpolate: bool = eqx.field(default=False, static=True)
    sem_rule: str = eqx.field(default="", static=True)
    upper: Float[np.ndarray, " time"] | None = eqx.field(default=None, converter=partial(_optional, name="upper"))
    quote: str = eqx.field(default="", static=True)
    exposure: Float[np.ndarray, " time"] | None = eqx.field(default=None, converter=partial(_optional, name="exposure"))

    def __check_init__(self):
        if self.values.ndim != 1 or not self.values.size:
            raise ValueError(f"values has shape {self.values.shape}; give a number for each time")
        for name in ("values", "time", "sem", "error", "weight", "upper", "exposure"):
            array = getattr(self, name)
            if array is None:
                continue
            if array.shape != self.values.shape and not (array.ndim == 0 and name in ("error", "weight")):
                raise ValueError(f"{name} has shape {array.shape} and values {self.values.shape}; make them equal")
            is_edge = self.upper is not None and name in ("values", "upper")
            _check(name, array, ~np.isnan(array) if is_edge else np.isfinite(array), "a finite number")
        self._check_band()
        if self.sem is not None:
            _check("sem", self.sem, self.sem >= 0, "0 or more")
        if self.error is not None:
            _check("error", self.error, self.error > 0, "a positive number")
        _check("weight", self.weight, self.weight >= 0, "0 or more")
        if self.exposure is not None:
            _check("exposure", self.exposure, self.exposure > 0, "a positive number of seconds")
            _check("values", self.values, self.values >= 0, "0 or more, a rate of counted spikes")
            if self.channel != "rate" or self.is_band or self.interpolate:
                raise ValueError("exposure is for counts of spikes: a curve in 'rate', at the frames of the stimulus")
        if self.time is not None:
            _check("time", self.time, np.diff(self.time, prepend=-np.inf) > 0, "times that increase")
        check_correlation(self.correlation_ms)

    @checked
    def on(self, stimulus: Stimulus) -> "Target":
        """The same target at the frames of the stimulus, every array a value a frame; weight 0 where it has no value.

        **Raises:** `ValueError` for values at other times than the frames', unless `interpolate` allows it, and then
        where it covers no frame, or so little of the stimulus that its times must have another unit.
        """
        frames = np.asarray(stimulus.time, dtype=float)
        if self.time is not None and self.interpolate:
            return self._interpolated(frames, self.time)
        self._check_grid(frames)
        error = None if self.error is None else np.broadcast_to(self.error, self.values.shape)
        weight = np.broadcast_to(self.weight, self.values.shape)
        return dataclasses.replace(self, error=error, weight=weight, time=frames, interpolate=False)

    @property
    def is_band(self) -> bool:
        """Whether it is a band, and no curve."""
        return self.upper is not None

    @property
    def has_error(self) -> bool:
        """Whether standard errors are known."""
        return self.error is not None or self.sem is not None

    @property
    def scale(self) -> Float[np.ndarray, " time"]:
        """Factor of a difference: sqrt(weight)/error.

        **Raises:** `ValueError` where the recorded standard error is 0 of all values that count.
        """
        weight = np.broadcast_to(self.weight, self.values.shape)
        error = self._sem_in_use if self.error is None else np.broadcast_to(self.error, self.values.shape)
        if error is None:
            return np.sqrt(weight)
        if not np.all(error[weight > 0]):
            raise ValueError("sem is 0 throughout; give an error that replaces it")
        return np.sqrt(weight) / np.where(weight > 0, error, 1)

    @property
    def rules(self) -> tuple[str, ...]:
        """How its samples are counted and its errors arose, where that is not plain, for a report."""
        rules = []
        if self._stride > 1:
            rules.append("values further apart than the frames: each is one sample, at the frame nearest to it")
        if self.correlation_ms:
            rules.append(f"a span of {self.correlation_ms:.3g} ms makes one independent sample")
        if self.is_band:
            rules.append("bands: a sample within is no difference and leaves no degree of freedom")
        if self.error is None and self.sem is not None:
            rules += [self.sem_rule] if self.sem_rule else []
            if np.any((self._sem_in_use > self.sem)[np.broadcast_to(self.weight > 0, self.sem.shape)]):
                rules.append(f"standard errors below {_LEAST_SEM:g} of their r.m.s. count as that")
        return tuple(rules)

    @property
    def thinning(self) -> Float[np.ndarray, " time"]:
        """For each value, how many values as close as its neighbours make one independent sample, at least 1.

        For a target at a stimulus's frames.
        """
        thinning, counted = np.ones(self.values.shape), np.flatnonzero(self.weight * np.ones(self.values.shape))
        if self.time is None or counted.size < 2 or not self.correlation_ms:
            return thinning
        interval = (self.time[-1] - self.time[0]) / (self.time.size - 1)
        apart = np.minimum(interval * np.diff(counted), self.correlation_ms)
        around = (np.append(apart[:1], apart) + np.append(apart, apart[-1:])) / 2
        thinning[counted] = self.correlation_ms / around
        return thinning

    @property
    def _stride(self) -> float:
        return stride(np.broadcast_to(self.weight, self.values.shape))

    @property
    def _sem_in_use(self) -> np.ndarray | None:
        """The standard errors, of plainly recorded ones none a small part of the others."""
        if self.sem is None or self.sem_rule:
            return self.sem
        counted = np.broadcast_to(self.weight > 0, self.sem.shape)
        usual = np.sqrt(np.mean(np.square(self.sem[counted]))) if counted.any() else 0.0
        return np.maximum(self.sem, _LEAST_SEM * usual)

    def _interpolated(self, frames: np.ndarray, time: np.ndarray) -> "Target":
        weight = np.broadcast_to(self.weight, self.values.shape)
        # Nothing is known between two values of which one does not count.
        known = np.interp(frames, time, weight > 0, left=0, right=0) == 1
        if weight.any():
            self._check_clock(frames, known)
        counted = known & _nearest(frames, known, time)
        values = _edge_at(frames, time, self.values)
        if np.any(counted != known) and not self.is_band:  # a band is no recording, with no noise to be kept
            values[counted] = self._carried(frames[counted])
        error = None if self.error is None else np.broadcast_to(self.error, self.values.shape)
        return dataclasses.replace(
            self,
            values=values,
            time=frames,
            sem=None if self.sem is None else np.interp(frames, time, self.sem),
            error=None if error is None else np.interp(frames, time, error),
            weight=np.where(counted, np.interp(frames, time, weight), 0.0),
            upper=None if self.upper is None else _edge_at(frames, time, self.upper),
            interpolate=False,
        )

    def _carried(self, frames: np.ndarray) -> np.ndarray:
        """The values nearest to these frames, carried there along the slope through their neighbours.

        Unlike a mean of two values, each is then as noisy as it was recorded, which residuals must show.
        """
        counted = np.broadcast_to(self.weight > 0, self.values.shape)
        time, values = np.asarray(self.time)[counted], self.values[counted]
        if values.size == 1:
            return np.full(frames.shape, values[0])
        nearest = np.rint(np.interp(frames, time, np.arange(len(time)))).astype(int)
        return values[nearest] + (frames - time[nearest]) * np.gradient(values, time)[nearest]

    def _check_band(self) -> None:
        if self.upper is None:
            return
        low, high = self.values, self.upper
        if np.any(low > high):
            first = int(np.argmax(low > high))
            raise ValueError(f"a band's lower edge is {low[first]:g} where the upper one is {high[first]:g}; swap them")
        if not np.all(np.isfinite(low) | np.isfinite(high)) or np.any(low == np.inf) or np.any(high == -np.inf):
            raise ValueError("a band has no finite edge; give one, or leave out the times where neither is known")
        if self.sem is not None:
            raise ValueError("a band has a sem, which only a curve has; give an error")

    def _check_clock(self, frames: np.ndarray, known: np.ndarray) -> None:
        """Refuse times that cannot be those of the stimulus."""
        time, start, end = np.asarray(self.time), float(frames[0]), float(frames[-1])
        reason = doubt(time, start, end)
        if reason and share_inside(time, start, end) > 0 and np.ptp(time) < end - start:
            raise ValueError(f"the target's times {reason}")
        if not known.any() or (reason and np.count_nonzero((time >= start) & (time <= end)) < 2):
            cure = f"; its times {reason}" if reason else ""
            raise ValueError(f"the target covers {_span(time)}: no frame of the stimulus, {_span(frames)}{cure}")

    def _check_grid(self, frames: np.ndarray) -> None:
        if self.values.shape != frames.shape:
            raise ValueError(
                f"the target has {self.values.size} values and the stimulus {frames.size} frames; "
                "give one a frame, or times and interpolate = true"
            )
        if self.time is None:
            return
        off = np.abs(self.time - frames) > _OFF_FRAME * np.min(np.diff(frames))
        if np.any(off):
            first = np.argmax(off)
            raise ValueError(
                f"the target has a value at {self.time[first]:g} ms where the stimulus has a frame at "
                f"{frames[first]:g} ms; set interpolate = true to move it onto the frames"
            )


def check_correlation(correlation_ms: float | int) -> None:
    """Raise `ValueError` for a span that is negative or not finite."""
    if not (np.isfinite(correlation_ms) and correlation_ms >= 0):
        raise ValueError(f"correlation_ms is {correlation_ms} ms; give 0 or more")


def stride(weight: Float[np.ndarray, " time"]) -> float:
    """Frames from one that counts to the next, as a rule: the median. `weight` is 0 where a frame does not count."""
    counted = np.flatnonzero(weight)
    return float(np.median(np.diff(counted))) if counted.size > 1 else 1.0


def _check(name: str, array: np.ndarray, fine: np.ndarray | np.bool, wanted: str) -> None:
    """Raise `ValueError` for the first element that is not fine."""
    if not np.all(fine):
        first = int(np.argmin(fine))
        where = f"{name}[{first}]" if array.ndim else name
        raise ValueError(f"{where} is {np.ravel(array)[first]:g}; give {wanted}")


def _nearest(frames: np.ndarray, known: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Which frames are, of those that are known, the nearest one of a value that is at most a frame away."""
    nearest, places = np.zeros(len(frames), bool), np.flatnonzero(known)
    if places.size:
        after = np.searchsorted(frames[places], time).clip(max=places.size - 1)
        pair = places[np.stack([(after - 1).clip(min=0), after])]
        distance = np.abs(frames[pair] - time)
        nearest[np.where(distance[0] <= distance[1], *pair)[distance.min(axis=0) <= np.ptp(frames[:2])]] = True
    return nearest


def _edge_at(frames: np.ndarray, time: np.ndarray, edge: np.ndarray) -> np.ndarray:
    """The values between times, linearly; infinite where one of the two neighbours is."""
    infinite = np.isinf(edge)
    between = np.interp(frames, time, np.where(infinite, 0.0, edge))
    if infinite.any():
        between[np.interp(frames, time, infinite) > 0] = edge[infinite][0]
    return between


def _span(time: np.ndarray) -> str:
    return f"{time[0]:g} to {time[-1]:g} ms"
