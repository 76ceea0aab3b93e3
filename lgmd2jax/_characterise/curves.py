"""Curves of one model over all trials, and what is measured on them: pure JAX, with times and windows as plain data."""

import dataclasses
from collections.abc import Sequence
from functools import partial
from typing import Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from lgmd2jax._characterise.exam import Exam, ExamSums, at_rate
from lgmd2jax._characterise.extremes import largest
from lgmd2jax._characterise.trials import REFERENCE, textured
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._signals import vertex

_REST_MS = 200.0  # last part of the lead-in, whose mean is rest
_WEAKEST = 0.05  # of SMP for the reference, of R for any other peak: what is smaller is no peak
_LEVEL = 1e-3  # of R below a maximum, within which a plateau reaches
_AFTER_MS = 150.0  # after the motion, in which what is answered still belongs to it

Mask = Bool[np.ndarray, "trial time"]
Values = Float[Array, " trial"]
Channel = Literal["adapted", "unadapted"]


@dataclasses.dataclass(frozen=True)
class Stack:
    """Curves of several trials: R over time in ms, the shorter ones held to the length of the longest."""

    values: Float[Array, "trial time"]
    time: Float[np.ndarray, "trial time"]
    begin: Float[np.ndarray, " trial"]
    end: Float[np.ndarray, " trial"]
    counts: tuple[int, ...]
    frame: float  # ms

    def between(self, start, stop) -> Mask:
        """From `start` to before `stop`, in ms, one number or one a trial."""
        start, stop = (np.broadcast_to(np.asarray(limit), self.begin.shape)[:, None] for limit in (start, stop))
        real = np.arange(self.time.shape[1]) < np.array(self.counts)[:, None]
        return (self.time >= start) & (self.time < stop) & real

    @property
    def motion(self) -> Mask:
        """From the onset to the frame that shows the end."""
        return self.between(self.begin, self.end + self.frame)

    @property
    def answer(self) -> Mask:
        """From the onset to 150 ms after the motion."""
        return self.between(self.begin, self.end + _AFTER_MS)

    def after(self, late: float = 0.0) -> Mask:
        """From `late` ms after the motion on, at least to the end of the lead-out."""
        return self.between(self.end + self.frame + late, np.inf)


class Curves(eqx.Module):
    """What the cell answers: (response - rest)/reference, before and after adaptation, for each group of trials.

    The reference is the peak of the dark approach at 40 ms, for textured scenes in the same scene; `references` holds
    both, by whether the scene is textured, in units of SMP. R is NaN where it is below .05, and NaN passes nothing.
    """

    exam: Exam = eqx.field(static=True)
    adapted: tuple[Float[Array, "_trial _time"], ...]
    unadapted: tuple[Float[Array, "_trial _time"], ...]
    references: dict[bool, Float[Array, ""]]

    def __call__(self, *names: str, channel: Channel = "adapted") -> Stack:
        """The curves of the named trials; one frame rate."""
        trials, curves = [self.exam.trial(name) for name in names], getattr(self, channel)
        times = [trial.time for trial in trials]
        longest = max(map(len, times))
        rows = [curves[g][i] for g, i in (self.exam.places[name] for name in names)]
        return Stack(
            jnp.stack([jnp.pad(row, (0, longest - len(row)), mode="edge") for row in rows]),
            np.stack([np.pad(time, (0, longest - len(time)), mode="edge") for time in times]),
            np.array([trial.begin for trial in trials]),
            np.array([trial.end for trial in trials]),
            tuple(map(len, times)),
            1000 / trials[0].fps,
        )


def curves_of(exam: Exam, sums: ExamSums, model: AbstractNetwork) -> Curves:
    """The cell stage. It maps over the cell's parameters, and needs no pixels for it."""
    smp, smp_adapted = [], []
    for group, of_group in zip(exam.groups, sums, strict=True):
        own, interval = at_rate(model, exam, group[0].fps), jnp.asarray(1000 / group[0].fps, dtype=float)
        response = jax.vmap(partial(own.respond, interval=interval, pixels=exam.eye.rows * exam.eye.cols))(of_group)
        smp.append(response.smp)
        smp_adapted.append(response.smp_adapted)
    return normalise(exam, smp, smp_adapted)


def normalise(
    exam: Exam, smp: Sequence[Float[Array, "_trial _time"]], smp_adapted: Sequence[Float[Array, "_trial _time"]]
) -> Curves:
    """Curves of both channels, a group after the other, above rest and in units of their reference."""
    adapted, unadapted = (tuple(map(_above_rest, exam.groups, channel)) for channel in (smp_adapted, smp))
    raw = Curves(exam, adapted, unadapted, {})
    references = {}
    for scene, name in ((False, REFERENCE), (True, textured(REFERENCE))):
        if name in exam.places:
            references[scene] = top(raw, name)[0]

    def in_references(curves):
        return tuple(
            curve / jnp.stack([_enough(references[trial.textured]) for trial in group])[:, None]
            for group, curve in zip(exam.groups, curves, strict=True)
        )

    return Curves(exam, in_references(adapted), in_references(unadapted), references)


def _enough(reference):
    return jnp.where(reference >= _WEAKEST, reference, jnp.nan)


def _above_rest(group, curves):
    rest = np.stack([(trial.time >= trial.begin - _REST_MS) & (trial.time < trial.begin) for trial in group])
    weights = rest / rest.sum(axis=1, keepdims=True)
    return curves - jnp.sum(curves * weights, axis=1, keepdims=True)


def highest(stack: Stack, mask: Mask) -> Values:
    """The largest value in a window."""
    return largest(jnp.where(mask, stack.values, -jnp.inf), axis=1)


def top(curves: Curves, *names: str, channel: Channel = "adapted") -> Values:
    """The peaks of R during the motion."""
    stack = curves(*names, channel=channel)
    return highest(stack, stack.motion)


def mean(stack: Stack, mask: Mask) -> Values:
    """The mean in a window."""
    return jnp.sum(stack.values * mask, axis=1) / mask.sum(axis=1)


def integral(stack: Stack) -> Values:
    """Over time in ms, from the onset to 150 ms after the motion; not below 0."""
    return jnp.maximum(jnp.sum(stack.values * stack.answer, axis=1) * stack.frame, 0)


def duration(stack: Stack, level: float) -> Values:
    """How long the curve is above a level from the onset on, in ms."""
    above = jnp.where(jnp.isnan(stack.values), jnp.nan, stack.values > level)
    return jnp.sum(above * stack.between(stack.begin, np.inf), axis=1) * stack.frame


def peak(stack: Stack) -> tuple[Values, Values]:
    """The largest value during the motion, and when, in ms: NaN where it is below .05, for then there is no peak.

    The time is the vertex of the parabola through the largest value and its neighbours; of three or more frames within
    1e-3 of R, a plateau, it is the middle.
    """
    mask = stack.motion
    inside = jnp.where(mask, stack.values, -jnp.inf)
    top, i = largest(inside, axis=1), jnp.argmax(inside, axis=1)
    left, right, frames = _run(stack, inside, i, top - _LEVEL)
    before, at, after = (_at(stack.values, i + step) for step in (-1, 0, 1))
    parabola = _at(stack.time, i) + stack.frame * vertex(before, at, after)
    time = jnp.where(frames >= 3, (left + right) / 2, parabola)
    return top, jnp.where(top >= _WEAKEST, time, jnp.nan)


def rise_and_fall(stack: Stack) -> tuple[Values, Values]:
    """From half of the peak to it and from there to half, in ms; infinite where the clip does not hold it."""
    top, time = peak(stack)
    i = jnp.argmax(jnp.where(stack.motion, stack.values, -jnp.inf), axis=1)
    real = stack.between(-np.inf, np.inf)
    left, right, _ = _run(stack, jnp.where(real, stack.values, jnp.inf), i, top / 2, beyond=jnp.inf)
    return time - left, right - time


def rise(stack: Stack, mask: Bool[Array | np.ndarray, "trial time"], backwards: bool = False) -> Values:
    """By how much the curve rises again after it has fallen, within a window, as time goes on (or back)."""
    lowest = jax.lax.cummin(jnp.where(mask, stack.values, jnp.inf), axis=1, reverse=backwards)
    return largest(jnp.where(mask, stack.values - lowest, 0), axis=1)


def second_rise(stack: Stack) -> Values:
    """By how much the curve rises again on the way down from its peak, on either side, during the motion."""
    mask = stack.motion
    i = jnp.argmax(jnp.where(mask, stack.values, -jnp.inf), axis=1)[:, None]
    index = np.arange(stack.time.shape[1])[None, :]
    return jnp.maximum(rise(stack, mask & (index >= i)), rise(stack, mask & (index <= i), backwards=True))


def _run(stack: Stack, values, i, level, beyond=0.0):
    """Where the curve crosses a level on either side of frame i, in ms, and how many frames lie between.

    Where the curve stays above the level up to the end of the window, that end stands for the crossing, `beyond` it.
    """
    index, size = np.arange(values.shape[1])[None, :], values.shape[1]
    below = values < level[:, None]
    low = jnp.max(jnp.where(below & (index < i[:, None]), index, -1), axis=1)
    high = jnp.min(jnp.where(below & (index > i[:, None]), index, size), axis=1)

    def crossing(outer, inner, edge):
        u, v, time = _at(values, outer), _at(values, inner), _at(stack.time, inner)
        crosses = jnp.isfinite(u) & (outer != edge)
        part = jnp.where(crosses, (v - level) / jnp.where(crosses & (v != u), v - u, 1), 0)
        return time + jnp.sign(outer - inner) * (stack.frame * part + jnp.where(outer == edge, beyond, 0))

    return crossing(low, low + 1, -1), crossing(high, high - 1, size), high - low - 1


def _at(values, i):
    """One value of each row, the ends for places beyond them."""
    values = jnp.asarray(values)
    return jnp.take_along_axis(values, jnp.clip(i, 0, values.shape[1] - 1)[:, None], axis=1)[:, 0]
