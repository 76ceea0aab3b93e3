# %% [markdown]
# # Your first fit
# A disc on its way to the eye, what the network makes of it, and the network fitted to the recorded firing rates of a
# locust's DCMD: three speeds are fitted, the fourth is predicted.

# %%
import jax
import matplotlib.pyplot as plt
import numpy as np

import lgmd2jax as lgmd

jax.config.update("jax_enable_x64", True)  # fits want double precision

# %% [markdown]
# ## A stimulus and a response
# An *eye* samples the world: 48 x 64 pixels of two degrees, 30 times a second. The disc is dark (Weber contrast -0.9)
# and comes with l/|v| = 60 ms: half its size by its speed. Time 0 is the collision.

# %%
eye = lgmd.Eye(rows=48, cols=64, degrees_per_pixel=2.0, fps=30.0)
disc = lgmd.stimuli.looming(eye, l_over_v=60.0, contrast=-0.9)
model = lgmd.LGMD2(eye=eye)  # the paper's network with its Table I
response = model(disc.frames, record=lambda layers: layers)
now = int(np.searchsorted(disc.time, -250))
figure, axes = plt.subplots(1, 4, figsize=(8, 2), layout="constrained")
for panel, name in zip(axes, ("frame", "off", "d_off", "s"), strict=True):
    panel.imshow(disc.frames[now] if name == "frame" else getattr(response.recorded, name)[now], cmap="gray")
    panel.set(title=name, xticks=[], yticks=[])

# %% [markdown]
# The change of luminance goes into an ON and an OFF pathway; this one is all OFF. Delayed and spread over neighbours it
# inhibits; S is what is left. Its sum over the field drives the potential, until the feed-forward inhibition shuts the
# cell.

# %%
figure, axes = plt.subplots(figsize=(8, 2.2), layout="constrained")
axes.plot(disc.time, response.smp_adapted, label="potential U'")
axes.plot(disc.time, response.spikes / 2, ".", label="spikes / 2")
axes.axvline(0, color="gray", linewidth=0.8)
axes.set(xlabel="time from collision (ms)", xlim=(-1500, 300))
axes.legend(frameon=False)

# %% [markdown]
# A batch is one `vmap`, and soft thresholds give slopes where hard ones give none.

# %%
contrasts = -jax.numpy.linspace(0.1, 0.9, 5)
clips = jax.vmap(lambda contrast: lgmd.stimuli.looming(eye, l_over_v=60.0, contrast=contrast).frames)(contrasts)
peaks = jax.vmap(model)(clips).smp_adapted.max(axis=1)
print("peaks by contrast .1 to .9:", ", ".join(f"{peak:.3f}" for peak in peaks))


def summed(parameters):
    return lgmd.LGMD2(parameters, lgmd.Soft(), eye=eye)(disc.frames).smp_adapted.sum()


print(f"slope of the summed potential in theta2: {jax.grad(summed)(lgmd.Parameters()).theta2:.3f}")

# %% [markdown]
# ## A fit
# The shipped protocol `dcmd` holds the stimuli of an experiment and the recorded rates. What is free stands in `Free`:
# bounds, or `None` for those that are declared with the parameter. All of these act after the pixels' sums, so that the
# pixels are computed once. `lgmd2jax fit dcmd` does the same with more parameters and more starts.

# %%
conditions = lgmd.load_protocol("dcmd").conditions
left_out = conditions[2]
free = lgmd.Free(
    k=(0.05, 3), tau2=lgmd.Log(20, 3000), tau3=lgmd.Log(50, 1500), T_ffi=lgmd.Log(1, 60), gain=None, latency=None
)
circuit = lgmd.preset("balanced", T_s=5, T_sfa=5e-4, sigma1=0.316, tau2=800, T_ffi=20)
fit = lgmd.fit(
    lgmd.LGMD2(circuit, eye=conditions[0].eye),
    [condition for condition in conditions if condition is not left_out],
    free,
    key=jax.random.key(0),
    observation=lgmd.Observation(baseline=5.0, gain=90.0, latency=55.0, smoothing=20.0),
    cell_points=256,
    descend=2,
    temperatures=(0.5, 0.2),
)
print(fit.summary())

# %% [markdown]
# Target, soft model, and the hard one that is handed over.

# %%
fit.plot().figure.set_size_inches(9, 3.2)

# %% [markdown]
# ## A prediction
# The speed that the fit has not seen, by the hard model.

# %%
predicted = fit.predict(left_out)
target = left_out.targets[0].on(left_out.render())
figure, axes = plt.subplots(figsize=(6, 2.5), layout="constrained")
axes.plot(left_out.render().time, target.values, color="black", label="recorded")
axes.plot(left_out.render().time, predicted, color="tab:orange", label="predicted")
axes.set(title=left_out.name, xlabel="time from collision (ms)", ylabel="spikes/s", xlim=(-600, 400))
axes.legend(frameon=False)
