"""The curve that a response is compared with, and what a difference from it weighs."""

import dataclasses
from typing import Any, Protocol, runtime_checkable

import equinox as eqx
import numpy as np
from jaxtyping import Float

from lgmd2jax._channels import TARGETS, Channel
from lgmd2jax._words import nearest
from lgmd2jax.stimuli import Stimulus

_OFF_FRAME = 0.01  # of a frame, by which times may miss the frames: what rounding in a CSV file does


@runtime_checkable
class AnyTarget(Protocol):
    """What becomes a target once the stimulus is known. A `Target` is one itself."""

    def on(self, stimulus: Stimulus) -> "Target":
        """The target at the frames of the stimulus."""
        ...


def _floats(values: Any) -> np.ndarray:
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"a target holds {values!r:.40}; give numbers") from None


def _optional(values: Any) -> np.ndarray | None:
    return None if values is None else _floats(values)


class Target(eqx.Module):
    """A curve over time in one channel of the response.

    **Arguments:**

    - `channel`: `"smp"`, `"smp_adapted"`, `"spikes"` (a frame), or `"rate"` (spikes/s, through an `Observation`).
    - `values`: in the unit of the channel.
    - `time`: of the values, in ms; None where they stand at the frames of the stimulus.
    - `sem`: standard error of the values where it was recorded. It is drawn, and is the error where none is given.
    - `error`: standard error by which a difference is divided, one number or one for each value.
    - `weight`: factor of the squared difference, one number or one for each value; 0 for what does not count.
    - `correlation_ms`: the span that makes one independent sample: 2 sqrt(pi) s behind a Gaussian of s.d. s.
    - `interpolate`: whether values at other times than the frames' may be interpolated onto these.

    **Raises:** `ValueError` for an unknown channel, for arrays of unequal lengths, for what is not finite, for times
    that do not increase, and for negative errors and weights.
    """

    channel: Channel = eqx.field(static=True)
    values: Float[np.ndarray, " time"] = eqx.field(converter=_floats)
    time: Float[np.ndarray, " time"] | None = eqx.field(default=None, converter=_optional)
    sem: Float[np.ndarray, " time"] | None = eqx.field(default=None, converter=_optional)
    error: Float[np.ndarray, " *#time"] | None = eqx.field(default=None, converter=_optional)
    weight: Float[np.ndarray, " *#time"] = eqx.field(default=1.0, converter=_floats)
    correlation_ms: float | int = eqx.field(default=0.0, static=True)
    interpolate: bool = eqx.field(default=False, static=True)

    def __check_init__(self):
        check_channel(self.channel)
        if self.values.ndim != 1 or not self.values.size:
            raise ValueError(f"values has shape {self.values.shape}; give a number for each time")
        for name in ("values", "time", "sem", "error", "weight"):
            array = getattr(self, name)
            if array is None:
                continue
            if array.shape != self.values.shape and not (array.ndim == 0 and name in ("error", "weight")):
                raise ValueError(f"{name} has shape {array.shape} and values {self.values.shape}; make them equal")
            _check(name, array, np.isfinite(array), "a finite number")
        if self.sem is not None:
            _check("sem", self.sem, self.sem >= 0, "0 or more")
        if self.error is not None:
            _check("error", self.error, self.error > 0, "a positive number")
        _check("weight", self.weight, self.weight >= 0, "0 or more")
        if self.time is not None:
            _check("time", self.time, np.diff(self.time, prepend=-np.inf) > 0, "times that increase")
        check_correlation(self.correlation_ms)

    def on(self, stimulus: Stimulus) -> "Target":
        """The same at the frames of the stimulus, every array of their number. What is not covered has weight 0.

        **Raises:** `ValueError` for values at other times than the frames', unless `interpolate` allows it, and then
        where it covers no frame.
        """
        frames = np.asarray(stimulus.time, dtype=float)
        weight = np.broadcast_to(self.weight, self.values.shape)
        error = None if self.error is None else np.broadcast_to(self.error, self.values.shape)
        curves = {"values": self.values, "sem": self.sem, "error": error}
        if self.time is not None and self.interpolate:
            # Nothing is known between two values of which one does not count.
            known = np.interp(frames, self.time, weight > 0, left=0, right=0) == 1
            if not known.any() and self.weight.any():
                raise ValueError(f"the target covers {_span(self.time)}: no frame of the stimulus, {_span(frames)}")
            curves = {
                name: None if curve is None else np.interp(frames, self.time, curve) for name, curve in curves.items()
            }
            weight = np.where(known, np.interp(frames, self.time, weight), 0.0)
        else:
            self._check_grid(frames)
        return dataclasses.replace(self, **curves, weight=weight, time=frames, interpolate=False)

    @property
    def has_error(self) -> bool:
        """Whether standard errors are known."""
        return self.error is not None or self.sem is not None

    @property
    def scale(self) -> Float[np.ndarray, " time"]:
        """Factor of a difference: sqrt(weight)/error.

        **Raises:** `ValueError` where a value counts whose recorded standard error is 0.
        """
        error = self.error if self.error is not None else self.sem
        weight = np.broadcast_to(self.weight, self.values.shape)
        if error is None:
            return np.sqrt(weight)
        error = np.broadcast_to(error, self.values.shape)
        _check("sem", error, (error > 0) | (weight == 0), "a positive number, or an error that replaces it")
        return np.sqrt(weight) / np.where(weight > 0, error, 1)

    @property
    def thinning(self) -> float:
        """How many frames make one independent sample, at least 1. For a target at the frames of a stimulus."""
        if self.time is None or self.time.size < 2:
            return 1.0
        interval = (self.time[-1] - self.time[0]) / (self.time.size - 1)
        return max(1.0, float(self.correlation_ms / interval))

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


def check_channel(channel: str) -> None:
    """Raise `ValueError` for a channel that a response does not have."""
    if channel not in TARGETS:
        raise ValueError(f"channel is {channel!r}; choose {nearest(channel, TARGETS)}")


def check_correlation(correlation_ms: float | int) -> None:
    """Raise `ValueError` for a span that is negative or not finite."""
    if not (np.isfinite(correlation_ms) and correlation_ms >= 0):
        raise ValueError(f"correlation_ms is {correlation_ms} ms; give 0 or more")


def _check(name: str, array: np.ndarray, fine: np.ndarray | np.bool, wanted: str) -> None:
    """Raise `ValueError` for the first element that is not fine."""
    if not np.all(fine):
        first = int(np.argmin(fine))
        where = f"{name}[{first}]" if array.ndim else name
        raise ValueError(f"{where} is {np.ravel(array)[first]:g}; give {wanted}")


def _span(time: np.ndarray) -> str:
    return f"{time[0]:g} to {time[-1]:g} ms"
