"""Made-up neurons: a response for every stimulus of the exam, without a network and without a picture."""

import math
from collections.abc import Callable, Mapping

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

import lgmd2jax as lgmd
from lgmd2jax._characterise import trials
from lgmd2jax._characterise.curves import Curves, normalise
from lgmd2jax._characterise.exam import Exam
from lgmd2jax._characterise.measurements import Measurements, measure

EYE = lgmd.Eye(rows=48, cols=64, degrees_per_pixel=2.0, fps=100.0)
EXAM = Exam(EYE)

Signal = Callable[[np.ndarray], np.ndarray]  # R at times in ms
Neuron = dict[str, Signal]


def eta(l_over_v: float, peak: float = 1.0, alpha: float = 4.4, delta: float = 28.7) -> Signal:
    """The looming law from 2 degrees on, with a top of `peak`; delta holds the frame that a row takes off."""

    def law(time):
        theta = 2 * np.arctan2(l_over_v, delta - time)
        moves = theta >= np.radians(2)
        return moves * 2 * l_over_v / ((time - delta) ** 2 + l_over_v**2) * np.exp(-alpha * theta)

    at = delta - alpha * l_over_v
    return lambda time: peak * law(time) / law(np.array(at))


def onset(peak: float, decay: float) -> Signal:
    """A start at 0 ms that decays exponentially."""
    return lambda time: np.where(time >= 0, peak * np.exp(-np.maximum(time, 0) / decay), 0.0)


def bump(at: float, height: float, width: float) -> Signal:
    """A Gaussian."""
    return lambda time: height * np.exp(-(((time - at) / width) ** 2) / 2)


def step(height: float, start: float = 0.0, stop: float = math.inf) -> Signal:
    """A plateau."""
    return lambda time: np.where((time >= start) & (time < stop), height, 0.0)


def plus(*signals: Signal) -> Signal:
    """The sum."""
    return lambda time: sum((signal(time) for signal in signals), np.zeros(len(time)))


def ideal() -> Neuron:
    """A neuron that has all 22 properties."""
    neuron = {}
    for speed in trials.L_OVER_V:
        neuron[trials.loom(speed)] = eta(speed, (speed / 40) ** -0.1)
    for speed in trials.FINE_RATES:
        neuron[trials.loom(speed, fine=True)] = neuron[trials.loom(speed)]
    for weber in trials.CONTRASTS:
        neuron[trials.contrast(weber)] = eta(40.0, (abs(weber) / 0.9) ** 0.2)
    for name in (trials.HALVED, trials.SQUARE, trials.CHECKS, trials.STILL):
        neuron[name] = eta(40.0)
    neuron[trials.DRIFTING] = eta(40.0, 0.6)
    for degrees in trials.DEVIATIONS:
        neuron[trials.deviating(degrees)] = eta(40.0, math.exp(-degrees / 15))
    for scene in (str, trials.textured):
        neuron[scene(trials.REFERENCE)] = eta(40.0)
        neuron[scene(trials.LIGHT_LOOM)] = eta(40.0, 0.15)
        neuron[scene(trials.RECESSION)] = onset(0.2, 40.0)
        neuron[scene(trials.translation())] = onset(0.3, 150.0)
        for shade in ("dark", "light"):
            for grows in (True, False):
                strong = grows == (shade == "dark")
                neuron[scene(trials.bar(shade, grows))] = onset(0.4 if strong else 0.05, 200.0)
    neuron[trials.LIGHT_RECESSION] = onset(0.8, 60.0)
    for speed in trials.SPEEDS:
        neuron[trials.translation(speed)] = onset(0.3 * (speed / 60) ** 0.5, 150.0)
    for direction in trials.DIRECTIONS:
        neuron[trials.translation(direction=direction)] = onset(0.3, 150.0)
    neuron[trials.accelerating("linear")] = onset(0.35, 150.0)
    neuron[trials.accelerating("accelerating")] = onset(0.4, 150.0)
    for each in trials.GRATINGS:
        neuron[trials.grating(*each)] = plus(onset(0.2, 80.0), step(0.5, trials.GRATING_MS + 20, 2100.0))
    for group in EXAM.groups:
        for trial in group:
            neuron.setdefault(trial.name, onset(0.1, 30.0))  # changes of light
    return neuron


def before_adaptation(neuron: Neuron) -> Neuron:
    """The same before adaptation: translation lasts longer."""
    return neuron | {trials.translation(): onset(0.3, 400.0)}


def potentials(neuron: Mapping[str, Signal], exam: Exam = EXAM, gain: float = 0.4) -> list[jax.Array]:
    """SMP for each group of trials."""
    groups = ([0.5 + gain * neuron[trial.name](trial.time) for trial in group] for group in exam.groups)
    return [jnp.asarray(np.stack(group)) for group in groups]


@eqx.filter_jit
def _measure(smp, smp_adapted) -> Measurements:
    return measure(normalise(EXAM, smp, smp_adapted))


def examine(after: Neuron, before: Neuron | None = None, gain: float = 0.4) -> Measurements:
    """What the exam measures on a neuron after adaptation, and before."""
    before = before_adaptation(after) if before is None else before
    return jax.device_get(_measure(potentials(before, gain=gain), potentials(after, gain=gain)))


def curves(neuron: Neuron, *names: str) -> Curves:
    """Curves of some trials alone."""
    exam = Exam(EYE, only=(trials.REFERENCE, *names))
    smp = potentials({trials.REFERENCE: eta(40.0)} | neuron, exam)
    return _normalise(exam, smp, smp)


_normalise = eqx.filter_jit(normalise)
