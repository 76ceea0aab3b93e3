# %% [markdown]
# # First steps
# A disc on its way to the eye, what each layer of the network makes of it, and what the cell answers.

# %%
import jax
import numpy as np

import lgmd2jax as lgmd
from notebooks import plots
from notebooks.paper_claims import see

# %% [markdown]
# An *eye* samples the world: 48 x 64 pixels of two degrees, 30 times a second. The disc is dark (Weber contrast -0.9)
# and comes with l/|v| = 60 ms: half its size by its speed.

# %%
eye = lgmd.Eye(rows=48, cols=64, degrees_per_pixel=2.0, fps=30.0)
stimulus = lgmd.stimuli.looming(eye, l_over_v=60.0, contrast=-0.9)
plots.strip(stimulus, at_ms=(-1000, -500, -250, -150, -100, 0))

# %% [markdown]
# `LGMD2()` is the paper's network with its Table I. `record` keeps what you want to see of its layers.

# %%
model = lgmd.LGMD2(eye=eye)
response = model(stimulus.frames, record=lambda layers: layers)
now = int(np.searchsorted(stimulus.time, -250))
layers = {name: np.asarray(getattr(response.recorded, name)[now]) for name in ("p", "off", "d_off", "s", "g")}
plots.maps({"frame": np.asarray(stimulus.frames[now]), **layers})

# %% [markdown]
# The change of luminance P goes into an ON and an OFF pathway; this one is all OFF. Delayed and spread over neighbours
# (d_off) it inhibits, S is what is left, G its local mean. MP is the sum of G, the SMP its sigmoid. Spikes come above
# the dashed lines; where FFI crosses its own, the cell is silenced.

# %%
plots.adaptation(
    {
        "dark disc, l/|v| 60 ms": see(
            model, lgmd.Condition("disc", eye, "looming", {"l_over_v": 60.0, "start_ms": -1500})
        )
    },
    (0.78, 0.88),
)

# %% [markdown]
# The same disc in white before black ground leaves it at rest. A batch of contrasts is one `vmap`, and the model is
# differentiable: soft thresholds give slopes where hard ones give none.

# %%
light = lgmd.stimuli.looming(eye, l_over_v=60.0, contrast=9.0, background=20.0)
print(f"peak SMP of the light disc: {model(light.frames).smp_adapted.max():.3f}")
clips = jax.vmap(lambda c: lgmd.stimuli.looming(eye, l_over_v=60.0, contrast=c).frames)(
    -jax.numpy.linspace(0.1, 0.9, 5)
)
peaks = jax.vmap(model)(clips).smp_adapted.max(axis=1)
print("peaks by contrast .1 to .9:", ", ".join(f"{peak:.3f}" for peak in peaks))


def summed(parameters):
    return lgmd.LGMD2(parameters, lgmd.Soft(), eye=eye)(stimulus.frames).smp_adapted.sum()


print(f"slope of the summed SMP in theta2: {jax.grad(summed)(lgmd.Parameters()).theta2:.3f}")
