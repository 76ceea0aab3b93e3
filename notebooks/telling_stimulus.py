# %% [markdown]
# # Simulation, and the most telling stimulus
# Stimuli and model are differentiable: so a model is a simulator for Bayesian inference with gradients, and a stimulus
# can be searched for that tells most.

# %%
import dataclasses
import pathlib
import tempfile
from typing import Any

import av
import blackjax
import jax
import jax.numpy as jnp
import numpy as np

import lgmd2jax as lgmd
from lgmd2jax._video.display import luminance_of
from notebooks import plots

jax.config.update("jax_enable_x64", True)

# %% [markdown]
# ## A simulator, and a twin's truth
# `as_simulator` takes a batch of parameters and gives summaries of the responses, in NumPy or JAX: here the rates in
# bins of 100 ms. Those of a twin, with the noise of 40 trials, give its parameters back through the no-U-turn sampler
# of blackjax. Their covariance is that of repeated simulation.

# %%
eye = lgmd.Eye(rows=12, cols=16, degrees_per_pixel=6.0, fps=60.0)
model = lgmd.LGMD2(lgmd.Parameters(T_s=5.0, T_sfa=5e-4, tau2=300.0), lgmd.Soft(1.0), eye=eye)
looms = [lgmd.stimuli.looming(eye, l_over_v=speed, contrast=-0.9, start_ms=-600, end_ms=300) for speed in (20.0, 40.0)]
free = lgmd.Free(k=(0.1, 2), gain=(50, 250))
simulator = lgmd.as_simulator(
    model,
    looms,
    free,
    observation=lgmd.Observation(baseline=6.0, latency=25.0),
    summaries=lambda time, rate: rate[:54].reshape(-1, 6).mean(axis=1),
    trials=40,
)
truth = np.array([0.4, 150.0])
data = simulator(truth, jax.random.key(1))
repeats = simulator(np.tile(truth, (400, 1)), jax.random.key(2))
precision = jnp.linalg.inv(jnp.cov(repeats.T))
low, high = jnp.asarray(simulator.low), jnp.asarray(simulator.high)


def log_density(x):
    z = jax.nn.sigmoid(x)
    off = simulator(low + (high - low) * z) - data
    return -0.5 * off @ precision @ off + jnp.sum(jax.nn.log_sigmoid(x) + jax.nn.log_sigmoid(-x))


warmup: Any = blackjax.window_adaptation(blackjax.nuts, log_density)
(state, tuned), _ = warmup.run(jax.random.key(3), jnp.zeros(2), 100)
sampler: Any = blackjax.nuts(log_density, **tuned)
_, draws = jax.lax.scan(
    lambda state, key: (moved := sampler.step(key, state)[0], moved.position),
    state,
    jax.random.split(jax.random.key(4), 200),
)
theta = np.asarray(low + (high - low) * jax.nn.sigmoid(draws))
for name, value, column in zip(simulator.names, truth, theta.T, strict=True):
    lower, upper = np.quantile(column, [0.025, 0.975])
    print(f"{name:5} truth {value:6.2f}, posterior {column.mean():6.2f}, 95 % within {lower:.2f} to {upper:.2f}")

# %% [markdown]
# ## What the neuron answers most
# The fitted LGMD2, on a display of 60 Hz: gradient ascent on the arguments of a looming object, judged by the hard
# model on whole grey levels, beside all conditions of the protocol that it was fitted to.

# %%
flagship = lgmd.load_fit("lgmd2")
screen = lgmd.Eye(rows=48, cols=64, degrees_per_pixel=2.0, fps=60.0)
window: dict[str, Any] = {"start_ms": -1700, "end_ms": 300}
vary = {"l_over_v": lgmd.Log(5, 80), "stop_angle": (20, 120), "contrast": (-1, -0.2), "background": (60, 220)}
protocol = [dataclasses.replace(it, eye=screen).render() for it in lgmd.load_protocol("lgmd2").conditions]


def against_protocol(found, unit):
    print(", ".join(f"{name} {value:.3g}" for name, value in found.arguments.items()))
    best = max(protocol, key=found.measured)
    print(f"{found.score:.4g} {unit}; the best of the protocol, {best.name}: {found.measured(best):.4g} {unit}")


strongest = lgmd.strongest_stimulus(flagship, "looming", vary, key=jax.random.key(0), eye=screen, starts=2, **window)
against_protocol(strongest, "ms of U' above rest")
plots.strip(strongest.stimulus, at_ms=(-600, -300, -150, -50, 0, 100))

# %% [markdown]
# As a video for the display, in 8 bits, with its gamma and a patch for the photodiode; and back: the hard model answers
# what the display shows as it answers the stimulus. The photodiode covers its patch.

# %%
path = pathlib.Path(tempfile.mkdtemp()) / "strongest.mkv"
lgmd.save_display_video(strongest.stimulus, path, gamma=2.2, scale=4)
with av.open(str(path)) as container:
    pictures = np.stack([frame.to_ndarray(format="gray")[2::4, 2::4] for frame in container.decode(video=0)])
frames = luminance_of(pictures, 2.2)
frames[:, -4:, :4] = frames[0, 0, 0]
shown = dataclasses.replace(strongest.stimulus, frames=jnp.asarray(frames))
print(f"{len(pictures)} frames; on the display {strongest.measured(shown):.4g} ms, before {strongest.score:.4g} ms")
print("photodiode:", pictures[:6, -1, 0])

# %% [markdown]
# ## What tells two circuits apart
# The paper's circuit and the fitted one with all mechanisms, under the noise of the recording: the distance of their
# responses in standard errors, the d' of an observer who knows both.

# %%
plain = lgmd.LGMD2(eye=dataclasses.replace(screen, fps=100.0))  # the rate that the fit was made at
telling = lgmd.discriminating_stimulus(
    plain, flagship, "looming", vary, key=jax.random.key(0), eye=screen, starts=1, **window
)
against_protocol(telling, "standard errors")
plots.strip(telling.stimulus, at_ms=(-600, -300, -150, -50, 0, 100))
