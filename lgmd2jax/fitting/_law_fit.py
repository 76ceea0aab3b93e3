"""What the looming law explains of the same recordings: the least that a network should do better."""

import dataclasses
from collections.abc import Mapping, Sequence

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from scipy.optimize import least_squares

from lgmd2jax._arguments.checked import checked
from lgmd2jax._channels import Channel
from lgmd2jax._signals import line_through, peak_times
from lgmd2jax._targets.looming_law import LoomingLaw, course
from lgmd2jax._targets.observation import Observation
from lgmd2jax._targets.target import Target
from lgmd2jax.fitting._curve import Curve, variance_explained
from lgmd2jax.fitting._validation import leave_one_out
from lgmd2jax.stimuli import Stimulus

Pairs = Sequence[tuple[Stimulus, Sequence[Target]]]
_FINER = 4  # points a frame: at small l/|v| eta rises and falls within two frames
# alpha, exponent of the gain, baseline and gain in spikes/s, latency in ms (delta is a part of it): start and bounds.
_START = (4.4, -0.1, 5.0, 100.0, 50.0)
_LOW, _HIGH = (1.0, -2.0, 0.0, 1.0, 0.0), (15.0, 2.0, 50.0, 2000.0, 150.0)


@dataclasses.dataclass(frozen=True)
class LawFit:
    """eta with a gain (l/|v|)^exponent, behind an observation as the network is."""

    alpha: float
    exponent: float
    observation: Observation

    @checked
    def predict(self, stimulus: Stimulus, channel: Channel = "rate") -> Float[np.ndarray, " time"]:
        """The rate at the frames of an approach. Other channels the law does not have."""
        time = np.asarray(stimulus.time, dtype=float)
        fine = np.interp(np.arange(0, len(time) - 1 + 1e-9, 1 / _FINER), np.arange(len(time)), time)
        # The observation counts from .5 up to 1: there the law's peak at l/|v| 40 ms has the rate `gain`.
        law = LoomingLaw(peak=0.5, alpha=self.alpha, delta=0, exponent=self.exponent)
        rate = self.observation(law.values(fine, *course(stimulus)), jnp.asarray(fine))
        return np.asarray(rate)[::_FINER]


@dataclasses.dataclass(frozen=True)
class PeakLine:
    """t_c - t_peak = alpha l/|v| - delta, in ms, by least squares, and how well it holds."""

    alpha: float
    delta: float
    r2: float


@dataclasses.dataclass(frozen=True)
class LawComparison:
    """Recording, network and looming law side by side.

    - `law`: fitted to all conditions, with alpha, exponent, baseline, gain and latency free. `r2`: of each condition.
    - `left_out`: the same of each condition, predicted by the law fitted to all others.
    - `peaks`: by condition, the time of the peak from collision, in ms, of recording, network (hard) and law.
    - `lines`: the line of peak times of each of the three.
    """

    law: LawFit
    r2: Mapping[str, float]
    left_out: Mapping[str, float]
    peaks: Mapping[str, tuple[float, float, float]]
    lines: Mapping[str, PeakLine]


def fit_law(pairs: Pairs, *, smoothing: float) -> LawFit:
    """The law that is nearest to the rates, by their weights, behind a Gaussian of `smoothing` ms."""

    def law_of(x: np.ndarray) -> LawFit:
        alpha, exponent, baseline, gain, latency = map(float, x)
        return LawFit(alpha, exponent, Observation(baseline, gain, latency, smoothing))

    def residuals(x: np.ndarray) -> np.ndarray:
        law = law_of(x)
        return np.concatenate(
            [(law.predict(stimulus) - target.values) * target.scale for stimulus, (target, *_) in pairs]
        )

    # Interpolation makes the residuals piecewise linear in the latency: steps of a thousandth step over the kinks.
    solution = least_squares(residuals, _START, bounds=(_LOW, _HIGH), x_scale=np.abs(_START), diff_step=1e-3)
    return law_of(solution.x)


def compare_with_law(pairs: Pairs, curves: Sequence[Curve], *, smoothing: float) -> LawComparison:
    """The comparison for approaches whose first target is a rate; `curves` are those of the fitted network."""
    law, hard = (
        fit_law(pairs, smoothing=smoothing),
        {curve.condition: curve.hard for curve in curves if curve.channel == "rate"},
    )
    r2, peaks = {}, {}
    for stimulus, (target, *_) in pairs:
        predicted = law.predict(stimulus)
        r2[stimulus.name] = variance_explained(target.values, predicted, target.weight)
        rates = target.values, hard[stimulus.name], predicted
        peaks[stimulus.name] = tuple(peak_times(np.asarray(stimulus.time), np.stack(rates)).tolist())
    left_out = leave_one_out(lambda others: fit_law(others, smoothing=smoothing).predict, pairs)
    speeds = np.array([stimulus.parameters["l_over_v"] for stimulus, _ in pairs], dtype=float)
    times = np.array(list(peaks.values()))
    lines = {name: _line(speeds, times[:, i]) for i, name in enumerate(("recording", "network", "looming law"))}
    return LawComparison(law, r2, left_out, peaks, lines)


def check_approaches(pairs: Pairs) -> None:
    """Raise `ValueError` unless the law can be held against all of these."""
    for stimulus, (target, *_) in pairs:
        if target.channel != "rate" or target.is_band or "l_over_v" not in stimulus.parameters:
            raise ValueError(
                f"looming_law is true, but {stimulus.name!r} is not an approach with a curve in 'rate'; leave it out"
            )
    if len({float(stimulus.parameters["l_over_v"]) for stimulus, _ in pairs}) < 2:
        raise ValueError("looming_law is true, but there is one l/|v| only; a line of peak times needs two")


def _line(speeds: np.ndarray, peak_times: np.ndarray) -> PeakLine:
    alpha, intercept, rest = line_through(-peak_times, speeds)
    spread = peak_times - peak_times.mean()
    return PeakLine(float(alpha), float(-intercept), float(1 - np.sum(rest**2) / np.sum(spread**2)))
