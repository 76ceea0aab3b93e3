# %% [markdown]
# # After the fit
# Spike trains of four animals, simulated so that the truth is known: what a fit of their single trials says, what can
# still be asked of it a week later, when it is loaded from its folder, and what holds over the animals.

# %%
import pathlib
import tempfile

import jax
import matplotlib.pyplot as plt
import numpy as np

import lgmd2jax as lgmd
from notebooks import plots

jax.config.update("jax_enable_x64", True)
folder = pathlib.Path(tempfile.mkdtemp()) / "fit"
eye = lgmd.Eye(rows=12, cols=16, degrees_per_pixel=6.0, fps=60.0)
model = lgmd.LGMD2(lgmd.Parameters(T_s=5.0, T_sfa=5e-4, tau2=300.0, k=0.4), lgmd.Soft(1.0), eye=eye)
looms = [lgmd.stimuli.looming(eye, l_over_v=speed, contrast=-0.9, start_ms=-600, end_ms=300) for speed in (20.0, 40.0)]
gains, latency = {"A": 110.0, "B": 150.0, "C": 180.0, "D": 140.0}, 25.0  # spikes/s, ms


def trials(stimulus, gain, seed, count=6):
    """Spikes of a Poisson process around the model's rate."""
    observation = lgmd.Observation(baseline=6.0, gain=gain, latency=latency, smoothing=15.0)
    rate = np.asarray(observation(model(stimulus.frames, stimulus.fps).smp_adapted, stimulus.time))
    generator, time = np.random.default_rng(seed), np.asarray(stimulus.time)
    trains = [np.sort(generator.uniform(time[0], time[-1], generator.poisson(0.9 * rate.max()))) for _ in range(count)]
    return [train[generator.uniform(0, rate.max(), len(train)) < np.interp(train, time, rate)] for train in trains]


conditions = [
    (
        loom,
        lgmd.SpikeTrains(
            [trials(loom, gain, 10 * i + j) for i, gain in enumerate(gains.values())],
            likelihood="poisson",
            animals=list(gains),
        ),
    )
    for j, loom in enumerate(looms)
]


def shown(axes):
    picture = plots.drawn(axes.figure)
    plt.close(axes.figure)
    return picture


# %% [markdown]
# ## Single trials
# `likelihood="poisson"` takes the spikes as an inhomogeneous Poisson process around the predicted rate: no kernel, no
# standard errors to be guessed, and an AIC that is -2 ln L + 2 p. `smoothing` is then the scatter of the response.

# %%
start = lgmd.Observation(gain=100.0, smoothing=15.0)
settings = {"key": jax.random.key(0), "observation": start, "pixel_points": 1, "cell_points": 64, "descend": 1}
free = lgmd.Free(gain=None, latency=None, baseline=None)
fit = lgmd.fit(model, conditions, free, **settings)
for name, (low, high) in zip(fit.free.names, fit.uncertainty.intervals, strict=True):
    print(f"{name:9} {fit.values[name]:6.1f}  95 % interval {low:.1f} to {high:.1f}")
print(f"AIC {fit.uncertainty.aic:.1f}; chi2 a degree of freedom {fit.uncertainty.reduced_chi2:.2f}")

# %% [markdown]
# ## A week later
# The folder holds stimuli and targets, or names the protocol that they came from, with a fingerprint: so a loaded fit
# profiles, samples, predicts, compares and plots, and refuses where the data have changed.

# %%
lgmd.save_fit(fit, folder)
again = lgmd.load_fit(folder)
profile = again.profile("gain")
print(f"gain by profile likelihood: {profile.interval[0]:.1f} to {profile.interval[1]:.1f}")
shown(again.plot_profile("gain", profile))

# %% [markdown]
# Residuals of counts are deviance residuals, in standard errors. What is alike for longer than a few frames is what the
# circuit cannot do.

# %%
shown(again.plot_residuals())

# %% [markdown]
# Which fixed parameter, freed, would help most? Where all are at their true values nothing stands out. Where the
# smoothing is fixed at a wrong one, it is the smoothing; and AIC says which is the better fit.

# %%
wrong = lgmd.fit(model, conditions, free, **{**settings, "observation": lgmd.Observation(gain=100.0, smoothing=60.0)})
for label, each in (("right", again), ("smoothing 60 ms", wrong)):
    best = each.score_test()[0]
    promised = f"{best.name}: chi2 falls by {best.decrease:.3g} (p {best.probability:.1g})"
    print(f"{label:15} AIC {each.uncertainty.aic:.1f}; {promised}")

# %% [markdown]
# ## Animals
# One fit an animal in one call; mean and spread by a random-effects model with the fits' own errors. The gains were 110
# to 180 spikes/s, with a standard deviation of 29; the latency was the same in all.

# %%
animals = lgmd.fit_each(model, conditions, free, by="animal", **settings)
print(animals.summary())

# %%
shown(animals.plot())
