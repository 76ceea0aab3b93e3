"""Whether a fit finds the parameters that its targets were made with: random sets, and what the fits give back.

python -m benchmarks.twins --count 100           soft targets at temperature 1: the parameters must come back
python -m benchmarks.twins --hard --count 20     hard targets: the handed-over hard model must give the same curves
python -m benchmarks.twins --noise .002 --count 200   noise: 95 % intervals of valid fits must cover the truth
python -m benchmarks.twins --mechanisms ...      the same of the circuit with all mechanisms, with their parameters
python -m benchmarks.twins --many ...            from 15 conditions instead of 5, which determine more parameters
"""

import argparse
import dataclasses
import time
from typing import Any, Literal, NamedTuple

import jax
import numpy as np
from jaxtyping import Bool
from tqdm import tqdm

import lgmd2jax as lgmd

SEARCH: dict[str, Any] = {"pixel_points": 32, "cell_points": 512, "descend": 2}  # enough for a soft set
PRECISE = 0.1  # of a parameter's range, below which its standard error must lie to be called well determined
MIDDLE = 0.7  # of each parameter's bounds, from which truths are drawn
SPIKE_ERROR = 10.0  # spikes are counted, not measured: a difference of one weighs as .1 in the potential


@dataclasses.dataclass(frozen=True)
class Circuit:
    """What is fitted: a network, which has the values of what stays fixed, and what is free."""

    network: lgmd.LGMD2
    free: lgmd.Free

    def truth(self, seed: int) -> dict[str, float]:
        """A random set from the middle of the declared bounds."""
        rng = np.random.default_rng(seed)
        return {
            each.name: each.low + (each.high - each.low) * rng.uniform(0.5 - MIDDLE / 2, 0.5 + MIDDLE / 2)
            for each in self.free.parameters
        }

    def model(self, values: dict[str, float], thresholds: lgmd.Thresholds) -> lgmd.LGMD2:
        """The network with these values."""
        parameters = dataclasses.replace(self.network.parameters, **values)
        return dataclasses.replace(self.network, parameters=parameters, thresholds=thresholds)


FREE = lgmd.Free(
    theta1=None, theta2=None, theta3=None, tau1=None, tau2=None, tau3=None, w_bias=None, T_sp=None
)  # fmt: skip
PLAIN = Circuit(lgmd.LGMD2(), FREE)
WITH_MECHANISMS = Circuit(
    lgmd.LGMD2(mechanisms=("size", "shunt", "lag", "membrane")),
    FREE.also(T_p=None, tau_hold=None, A_ffi=None, m=None, gamma=None, lag=None, tau_cell=None),
)


@dataclasses.dataclass(frozen=True)
class Twin:
    """One parameter set and what the fit made of its curves.

    - `off`: largest difference of a parameter, as a share of its bounds' range.
    - `rmse`: of the handed-over model in `smp_adapted`. `miscounted`: share of frames with another spike count.
    """

    seed: int
    truth: dict[str, float]
    fit: lgmd.Fit
    off: float
    rmse: float
    miscounted: float
    seconds: float


def stimuli(eye: lgmd.Eye) -> list[lgmd.Stimulus]:
    """Five conditions of four families, 60 frames at 30 fps each."""
    approach: dict[str, Any] = {"l_over_v": 60.0, "start_angle": 4.0, "start_ms": -1600.0, "end_ms": 366.0}
    later: dict[str, Any] = {"start_ms": -300.0, "end_ms": 1666.0}
    show = lgmd.stimuli
    return [
        show.looming(eye, contrast=-0.9, background=200.0, **approach),
        show.looming(eye, contrast=4.0, background=40.0, **approach),
        show.receding(
            eye, l_over_v=60.0, contrast=-0.9, background=200.0, stop_angle=4.0, start_ms=-500.0, end_ms=1466.0
        ),
        show.translating(eye, speed=60.0, size=10.0, start=-50.0, stop=50.0, contrast=-0.9, background=200.0, **later),
        show.grating(
            eye,
            spatial_frequency=0.05,
            temporal_frequency=2.0,
            contrast=1.0,
            background=110.0,
            duration_ms=1000.0,
            **later,
        ),
    ]


def many_stimuli(eye: lgmd.Eye) -> list[lgmd.Stimulus]:
    """These and ten more, of other contrasts and speeds, and changes of light: what determines the mechanisms too."""
    later: dict[str, Any] = {"start_ms": -300.0, "end_ms": 1666.0}
    show = lgmd.stimuli

    def loom(l_over_v: float, contrast: float, background: float = 200.0) -> lgmd.Stimulus:
        approach: dict[str, Any] = {"start_angle": 4.0, "start_ms": -1600.0, "end_ms": 366.0}
        return show.looming(eye, l_over_v=l_over_v, contrast=contrast, background=background, **approach)

    def translation(speed: float, contrast: float) -> lgmd.Stimulus:
        path: dict[str, Any] = {"size": 10.0, "start": -50.0, "stop": 50.0}
        return show.translating(eye, speed=speed, contrast=contrast, background=200.0, **path, **later)

    faint: dict[str, Any] = {"spatial_frequency": 0.02, "temporal_frequency": 1.0, "contrast": 0.1}
    return [
        *stimuli(eye),
        *(loom(*each) for each in ((30.0, -0.9), (120.0, -0.9), (60.0, -0.3), (60.0, -0.1), (30.0, 4.0, 40.0))),
        *(translation(*each) for each in ((20.0, -0.3), (200.0, -0.9))),
        show.grating(eye, background=110.0, duration_ms=1000.0, **faint, **later),
        *(
            show.luminance(eye, level=level, background=200.0, fraction=fraction, ramp_ms=0.0, **later)
            for level, fraction in ((100.0, 0.25), (195.0, 1.0))
        ),
    ]


def eye_of(degrees_per_pixel: float) -> lgmd.Eye:
    """The field of 96 x 128 degrees at 30 fps."""
    return lgmd.Eye(round(96 / degrees_per_pixel), round(128 / degrees_per_pixel), degrees_per_pixel, 30.0)


def curves(model: lgmd.AbstractNetwork, shown: list[lgmd.Stimulus]) -> list[lgmd.Response]:
    """The responses to all stimuli."""
    return [model(stimulus.frames, stimulus.fps) for stimulus in shown]


def twin(
    seed: int, thresholds: lgmd.Thresholds, shown: list[lgmd.Stimulus], circuit: Circuit = PLAIN, **settings
) -> Twin:
    """Fit the curves of a random parameter set."""
    began, truth = time.monotonic(), circuit.truth(seed)
    answered = curves(circuit.model(truth, thresholds), shown)
    conditions = [
        (
            stimulus,
            [
                lgmd.Target("smp_adapted", np.asarray(response.smp_adapted)),
                lgmd.Target("spikes", np.asarray(response.spikes), error=SPIKE_ERROR),
            ],
        )
        for stimulus, response in zip(shown, answered, strict=True)
    ]
    start = circuit.model({}, thresholds)
    fit = lgmd.fit(start, conditions, circuit.free, key=jax.random.key(seed), **settings)
    fitted = curves(fit.model, shown)
    potential = [(a.smp_adapted - b.smp_adapted) for a, b in zip(fitted, answered, strict=True)]
    miscounted = [np.abs(a.spikes - b.spikes) >= 0.5 for a, b in zip(fitted, answered, strict=True)]
    return Twin(
        seed=seed,
        truth=truth,
        fit=fit,
        off=max(
            abs(fit.values[free.name] - truth[free.name]) / (free.high - free.low) for free in circuit.free.parameters
        ),
        rmse=float(np.sqrt(np.mean(np.square(potential)))),
        miscounted=float(np.mean(miscounted)),
        seconds=time.monotonic() - began,
    )


class Coverage(NamedTuple):
    """What the intervals of a fit are worth.

    - `held`: whether the 95 % interval of a parameter holds the truth.
    - `known`: whether the fit calls the parameter well determined: neither undetermined nor rough, within a tenth of
      its range.
    - `valid`: whether the fit calls itself valid. One that ended in another minimum says by its misfit that it is not.
    """

    held: Bool[np.ndarray, " free"]
    known: Bool[np.ndarray, " free"]
    valid: bool


def coverage(seed: int, noise: float, shown: list[lgmd.Stimulus], circuit: Circuit = PLAIN, **settings) -> Coverage:
    """Fit the curves of a random soft set, with noise on the potential and on the spikes."""
    truth, thresholds, rng = circuit.truth(seed), lgmd.Soft(1.0), np.random.default_rng(seed)

    def noisy(channel: Literal["smp_adapted", "spikes"], curve, error: float) -> lgmd.Target:
        return lgmd.Target(channel, np.asarray(curve) + error * rng.standard_normal(len(curve)), error=error)

    conditions = [
        (
            stimulus,
            [
                noisy("smp_adapted", response.smp_adapted, noise),
                noisy("spikes", response.spikes, SPIKE_ERROR * noise),
            ],
        )
        for stimulus, response in zip(shown, curves(circuit.model(truth, thresholds), shown), strict=True)
    ]
    start = circuit.model({}, thresholds)
    fit = lgmd.fit(start, conditions, circuit.free, key=jax.random.key(seed), **settings)
    u, values = fit.uncertainty, np.array(list(truth.values()))
    straight = np.array([name not in fit.nonlinear for name in u.names])
    within = u.standard_errors < PRECISE * np.array([free.high - free.low for free in circuit.free.parameters])
    held = (u.intervals[:, 0] <= values) & (values <= u.intervals[:, 1])
    return Coverage(held, u.determined & straight & within, fit.status[0] == "valid")


def _line(name: str, held: Bool[np.ndarray, "..."], known: Bool[np.ndarray, "..."]) -> str:
    """How often intervals hold the truth: of parameters that are well determined, and of all."""
    share = f"{held[known].mean():6.1%}" if known.any() else "     -"
    return f"{name:8} covered {share} of {known.sum():4} well determined, {held.mean():6.1%} of all {held.size:4}"


def main() -> None:
    """Run a study and print a line for each twin."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hard", action="store_true", help="hard targets")
    parser.add_argument("--mechanisms", action="store_true", help="the circuit with all mechanisms")
    parser.add_argument("--many", action="store_true", help="15 conditions instead of 5")
    parser.add_argument("--noise", type=float, help="standard deviation of noise on the potential: coverage")
    parser.add_argument("--count", type=int, default=20, help="parameter sets (default: %(default)s)")
    parser.add_argument("--first", type=int, default=0, help="seed of the first one (default: %(default)s)")
    parser.add_argument("--degrees-per-pixel", type=float, default=4.0, help="raster (default: %(default)s)")
    options = parser.parse_args()
    jax.config.update("jax_enable_x64", True)
    circuit = WITH_MECHANISMS if options.mechanisms else PLAIN
    shown = (many_stimuli if options.many else stimuli)(eye_of(options.degrees_per_pixel))
    seeds = tqdm(range(options.first, options.first + options.count), unit="twin")
    if options.noise:
        fits = [coverage(seed, options.noise, shown, circuit, **SEARCH) for seed in seeds]
        valid = [fit for fit in fits if fit.valid]
        print(f"{len(valid)} of {options.count} fits are valid; of their 95 % intervals")
        if valid:
            held, known = np.array([fit.held for fit in valid]), np.array([fit.known for fit in valid])
            for name, holds, judged in zip(circuit.free.names, held.T, known.T, strict=True):
                print(_line(name, holds, judged))
            print(_line("together", held, known))
        return
    thresholds = lgmd.Hard() if options.hard else lgmd.Soft(1.0)
    good = 0
    for seed in seeds:
        result = twin(seed, thresholds, shown, circuit)
        holds = (result.rmse <= 0.01 and result.miscounted <= 0.02) if options.hard else result.off <= 0.01
        good += holds
        tqdm.write(
            f"{seed:4}  {'holds' if holds else 'FAILS'}  largest difference {result.off:8.2%} of the range   "
            f"RMSE {result.rmse:.5f}   other spike counts {result.miscounted:6.2%}   {result.seconds:5.1f} s"
        )
    print(f"{good} of {options.count} hold")


if __name__ == "__main__":
    main()
