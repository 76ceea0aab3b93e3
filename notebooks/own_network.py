# %% [markdown]
# # A network of your own
# A detector that counts pixels which dim, written as two stages: pixels, which see frames, and a cell, which sees two
# sums a frame. As a subclass of `AbstractNetwork` it is called, streamed, differentiated, fitted, swept, characterised,
# saved and loaded as the library's own are.

# %%
import pathlib
import tempfile
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
from jaxtyping import Array, Float

import lgmd2jax as lgmd

jax.config.update("jax_enable_x64", True)  # fits want double precision
Scalar = Float[Array, ""]
Map = Float[Array, "row col"]

# %% [markdown]
# ## Parameters
# Each with its meaning, unit, domain, the bounds of a fit and a source. `stage` tells a fit where a parameter acts, and
# `per_frame` what becomes of it at another frame rate.


# %%
class DimmingParameters(lgmd.ParameterSet):
    """What a dimming detector is free to have."""

    T_dim: Scalar = eqx.field(
        default=6.0,
        converter=lgmd.scalar,
        metadata=lgmd.declares(
            "fall of luminance in a frame that counts", "grey level", "[0, inf)", (1.0, 30.0), "a guess", "log",
            stage="pixels", per_frame="change",
        ),
    )  # fmt: skip
    tau: Scalar = eqx.field(
        default=60.0,
        converter=lgmd.scalar,
        metadata=lgmd.declares("time constant of the cell", "ms", "(0, inf)", (10.0, 300.0), "a guess", scale="log"),
    )
    k: Scalar = eqx.field(
        default=1.5,
        converter=lgmd.scalar,
        metadata=lgmd.declares(
            "mean fall that maps to sigma(1)", "grey level", "(0, inf)", (0.1, 10.0), "a guess", "log",
            per_frame="change",
        ),
    )  # fmt: skip
    T_sp: Scalar = eqx.field(
        default=0.7,
        converter=lgmd.scalar,
        metadata=lgmd.declares("potential from which there is a spike", "1", "(0.5, 1)", (0.55, 0.95), "a guess"),
    )


# %% [markdown]
# ## Two stages
# Each says how it rests and what one frame does. Thresholds are given, so that the same lines are the hard model and
# the soft one with slopes.


# %%
class DimmingPixels(lgmd.AbstractPixels):
    """Counts what dims by more than T_dim."""

    parameters: DimmingParameters
    thresholds: lgmd.Thresholds

    def rest(self, frame: Map) -> Map:
        return frame

    def step(self, state: Map, frame: Map, interval: Scalar) -> tuple[Map, lgmd.Sums, Map]:
        fall = jnp.maximum(state - frame, 0)
        counted = fall * self.thresholds.s(fall, self.parameters.T_dim)
        return frame, lgmd.Sums(counted.sum(), jnp.abs(frame - state).mean()), counted


class DimmingCell(lgmd.AbstractCell):
    """Adds up leakily, spikes, and alarms after N_alarm spikes in a row."""

    parameters: DimmingParameters
    thresholds: lgmd.Thresholds
    N_alarm: int = eqx.field(static=True)

    def rest(self) -> tuple[Scalar, Array]:
        dtype = self.parameters.dtype
        return jnp.zeros((), dtype), jnp.zeros(self.N_alarm - 1, dtype)

    def step(self, state: Any, sums: lgmd.Sums, interval: Scalar, pixels: int) -> tuple[Any, lgmd.Response]:
        v, (excitation, past) = self.parameters, state
        excitation += interval / (interval + v.tau) * (sums.mp / (pixels * v.k) - excitation)
        u = jax.nn.sigmoid(excitation)
        spikes = self.thresholds.spikes(u, v.T_sp, jnp.ones_like(u))
        window = jnp.append(past, spikes)
        alarm = self.thresholds.collision(window.sum(), jnp.full_like(u, self.N_alarm))
        return (excitation, window[1:]), lgmd.Response(sums.mp, sums.f, u, u, spikes, alarm)


class Dimming(lgmd.AbstractNetwork):
    """A dimming detector."""

    parameters: DimmingParameters = eqx.field(default_factory=DimmingParameters)
    thresholds: lgmd.Thresholds = eqx.field(default_factory=lgmd.Hard)
    N_alarm: int = lgmd.counts(3, "spikes", least=1)
    eye: lgmd.Eye | None = eqx.field(default=None, static=True)

    @property
    def pixels(self) -> DimmingPixels:
        return DimmingPixels(self.parameters, self.thresholds)

    @property
    def cell(self) -> DimmingCell:
        return DimmingCell(self.parameters, self.thresholds, self.N_alarm)


# %% [markdown]
# ## Called, streamed, differentiated

# %%
eye = lgmd.Eye(rows=24, cols=32, degrees_per_pixel=4.0, fps=60.0)
dark, light = (
    lgmd.stimuli.looming(eye, l_over_v=40.0, level=level, background=ground, start_ms=-800, end_ms=300)
    for level, ground in ((20.0, 200.0), (200.0, 20.0))
)
model = Dimming(eye=eye)
response = model(dark.frames)
state = model.init(dark.frames[0])
streamed = []
for frame in dark.frames:
    state, now = model.step(state, frame)
    streamed.append(float(now.smp_adapted))
print("streamed as called:", np.allclose(streamed, response.smp_adapted))
print(
    "alarm first at",
    float(dark.time[int(np.argmax(response.collision))]),
    "ms; for a light disc:",
    bool(model(light.frames).collision.any()),
)
slope = jax.grad(lambda p: Dimming(p, lgmd.Soft(), eye=eye)(dark.frames).smp_adapted.sum())(DimmingParameters())
print(f"slope of the summed potential in T_dim: {slope.T_dim:.4f}")

# %% [markdown]
# ## Fitted
# To what a detector with other parameters answers: they come back.

# %%
truth = DimmingParameters(T_dim=10.0, tau=90.0, k=2.5)
twin = Dimming(truth, eye=eye)
fit = lgmd.fit(
    model,
    [(stimulus, lgmd.ModelTarget(model=twin, channel="smp_adapted")) for stimulus in (dark, light)],
    lgmd.Free(T_dim=None, tau=None, k=None),
    key=jax.random.key(0),
    pixel_points=16,
    cell_points=128,
    descend=2,
)
for name, value in fit.values.items():
    print(f"{name:6} {value:8.3f}, truth {float(getattr(truth, name)):g}")
figure, axes = plt.subplots(figsize=(6, 2.5), layout="constrained")
for network, label in ((model, "start"), (twin, "target"), (fit.model, "fitted")):
    axes.plot(dark.time, network(dark.frames).smp_adapted, "--" if label == "fitted" else "-", label=label)
axes.set(xlabel="time from collision (ms)", xlim=(-500, 300))
axes.legend(frameon=False)

# %% [markdown]
# ## Fitted to recordings, beside another circuit
# A shipped protocol brings stimuli with the recorded rates; an observation makes a rate of the potential. Here few
# points are searched. As in the shipped fit, the misfit sets the scale of all errors.

# %%
conditions = lgmd.load_protocol("dcmd").conditions
recorded = lgmd.fit(
    Dimming(eye=conditions[0].eye),
    conditions,
    lgmd.Free(T_dim=None, tau=None, k=None, baseline=None, gain=None, latency=None),
    key=jax.random.key(0),
    observation=lgmd.Observation(baseline=5.0, gain=90.0, latency=55.0, smoothing=20.0),
    absolute_errors=False,
    pixel_points=4,
    cell_points=256,
    descend=1,
)
print(lgmd.compare({"dimming": recorded, "LGMD2 with a shunt": "dcmd"}))

# %% [markdown]
# ## Characterised
# Which of the 22 response properties it has. It is judged as any LGMD, which may answer light objects too.

# %%
found = lgmd.characterise(model)
print(found.passed, "of", found.judged, "properties hold; those that do not:")
print("; ".join(finding.name for finding in found.rows if finding.passed is False))

# %% [markdown]
# ## Saved and loaded
# A fit becomes a folder with its report, a model a file that proves itself on loading, as the library's own do; both
# are loaded with the class. Commands and `hard.py` know the library's networks alone, and say so.

# %%
folder = pathlib.Path(tempfile.mkdtemp()) / "dimming"
lgmd.save_fit(recorded, folder)
print(lgmd.load_fit(folder, network=Dimming).status[0])
again = lgmd.load(folder / "model.json", network=Dimming)
print(again.parameters)
