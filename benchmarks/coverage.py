"""How often the 95 % intervals of fits to single spike trains contain the true values.

python -m benchmarks.coverage                  200 sets of trains
python -m benchmarks.coverage --sets 50 --trials 4

Spikes are drawn from an inhomogeneous Poisson process around the rate of a known circuit, and fitted by the Poisson
likelihood: gain, baseline and latency, which the observation has, and k, which the cell has.
"""

import argparse

import jax
import numpy as np
from tqdm import tqdm

import lgmd2jax as lgmd

EYE = lgmd.Eye(rows=12, cols=16, degrees_per_pixel=6.0, fps=60.0)
MODEL = lgmd.LGMD2(lgmd.Parameters(T_s=5.0, T_sfa=5e-4, tau2=300.0, k=0.4), lgmd.Soft(1.0), eye=EYE)
TRUTH = lgmd.Observation(baseline=6.0, gain=150.0, latency=25.0, smoothing=15.0)
FREE = lgmd.Free(gain=None, baseline=None, latency=None, k=None)


def main() -> None:
    """Fit all sets and print the shares."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sets", type=int, default=200)
    parser.add_argument("--trials", type=int, default=6, help="of each condition (default: 6)")
    options = parser.parse_args()
    jax.config.update("jax_enable_x64", True)
    looms = [
        lgmd.stimuli.looming(EYE, l_over_v=l_over_v, contrast=-0.9, start_ms=-700.0, end_ms=300.0)
        for l_over_v in (20.0, 40.0)
    ]
    rates = [np.asarray(TRUTH(MODEL(loom.frames, loom.fps).smp_adapted, loom.time)) for loom in looms]
    truth = {name: float(getattr(TRUTH if hasattr(TRUTH, name) else MODEL.parameters, name)) for name in FREE.names}
    held = []
    for number in tqdm(range(options.sets), unit="set", leave=False):
        generator = np.random.default_rng(number)
        conditions = [
            (loom, lgmd.SpikeTrains([[_train(rate, loom, generator) for _ in range(options.trials)]], 20.0, "poisson"))
            for loom, rate in zip(looms, rates, strict=True)
        ]
        settings = {"pixel_points": 1, "cell_points": 64, "descend": 1}
        fit = lgmd.fit(MODEL, conditions, FREE, key=jax.random.key(0), observation=TRUTH, **settings)
        ends = fit.uncertainty.intervals
        held.append([low <= truth[name] <= high for name, (low, high) in zip(FREE.names, ends, strict=True)])
    shares = np.mean(held, axis=0)
    for name, share in zip(FREE.names, shares, strict=True):
        print(f"{name:9} {share:.1%}")
    print(f"all       {np.mean(held):.1%} of {np.size(held)} intervals of {options.sets} sets")


def _train(rate: np.ndarray, stimulus: lgmd.Stimulus, generator: np.random.Generator) -> np.ndarray:
    """Spikes of an inhomogeneous Poisson process, by thinning (Lewis & Shedler, 1979)."""
    time, most = np.asarray(stimulus.time), 1.01 * rate.max()
    start, end = time[0] - 500 / stimulus.fps, time[-1] + 500 / stimulus.fps
    spikes = np.sort(generator.uniform(start, end, generator.poisson(most * (end - start) / 1000)))
    return spikes[generator.uniform(0, most, len(spikes)) < np.interp(spikes, time, rate)]


if __name__ == "__main__":
    main()
