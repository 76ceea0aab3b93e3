# %% [markdown]
# # A fit to biology
# Recorded firing rates of a locust's DCMD while discs loom at four speeds. The network is fitted to three of them and
# predicts the fourth.

# %%
import jax

import lgmd2jax as lgmd
from notebooks import plots

jax.config.update("jax_enable_x64", True)  # fits want double precision
conditions = lgmd.load_protocol("dcmd").conditions
left_out = conditions[2]
print("left out:", left_out.name)

# %% [markdown]
# Two kinds of targets: the recording itself, and the law that such neurons obey: the rate follows the speed of the
# angle, times an exponential of the angle, a little later (Gabbiani, Krapp & Laurent 1999). The recording's times hold
# the latency of tablet and sound card, some 55 ms, which the law does not.

# %%
law = lgmd.LoomingLaw(peak=75.0, alpha=4.4, delta=18.7, channel="rate", rest=5.0)
plots.targets(conditions, law)

# %% [markdown]
# What is free, and where. `None` takes the bounds that are declared with the parameter. All of these act after the
# pixels' sums, so that the pixels are computed once; `lgmd2jax fit dcmd` frees an exponent of the drive beside.

# %%
free = lgmd.Free(
    k=(0.05, 3), tau2=lgmd.Log(20, 3000), tau3=lgmd.Log(50, 1500), T_ffi=lgmd.Log(1, 60), gain=None, latency=None
)
circuit = lgmd.preset("balanced", T_s=5, T_sfa=5e-4, sigma1=0.316, tau2=800, T_ffi=20)
model = lgmd.LGMD2(circuit, eye=conditions[0].eye)
observation = lgmd.Observation(baseline=5.0, gain=90.0, latency=55.0, smoothing=20.0)
fit = lgmd.fit(
    model,
    [it for it in conditions if it is not left_out],
    free,
    key=jax.random.key(0),
    observation=observation,
    cell_points=256,
    descend=2,
    temperatures=(0.5, 0.2),
)
print(fit.summary())

# %% [markdown]
# The fit, by the hard model that is handed over, and the speed that it has not seen.

# %%
plots.fitted(fit, conditions, left_out)
