# %% [markdown]
# # Compare circuits
# The paper's circuit holds at most 16 of the 22 response properties, of 278,528 models that were tried; with four
# optional mechanisms a fitted one holds 20 ([which, and at what cost](../fits/lgmd2/properties.md)). Here is why the
# paper's circuit cannot, and what each mechanism does to a fit of recordings.

# %%
import jax
import matplotlib.pyplot as plt
import numpy as np

import lgmd2jax as lgmd

jax.config.update("jax_enable_x64", True)
eye = lgmd.Eye(rows=48, cols=64, degrees_per_pixel=2.0, fps=100.0)

# %% [markdown]
# ## Why the paper's circuit cannot
# The drive of the cell is MP, the sum over pixels of how much they change. The inhibition that must end the response
# is F, the mean of how much they change: the same quantity, edge length times speed times step of luminance. So the
# angle of the disc at which F passes its threshold moves with contrast and with speed. With **A** (`"size"`) F is the
# share of the field that changed recently: it grows with the disc, whatever its contrast.
#
# Below, the angle at which the inhibition passes its threshold, in frames of 10 ms. Both thresholds are set at the
# frame at which a loom of contrast -.9 at 40 ms passes 35 degrees. At 10 ms the delays, some tens of ms, count too.

# %%
CONTRASTS, SPEEDS = (-0.3, -0.5, -0.7, -0.9), (10.0, 20.0, 40.0, 80.0)
circuits = {
    "mean |P|, the paper's": lgmd.LGMD2(eye=eye),
    "share of the field (A)": lgmd.LGMD2(eye=eye, mechanisms=("size",)),
}


def course(model, contrast, l_over_v):
    """The angle of the disc and the delayed inhibition at each frame of its approach."""
    disc = lgmd.stimuli.looming(
        eye,
        l_over_v=l_over_v,
        contrast=contrast,
        background=200.0,
        start_angle=6.0,
        stop_angle=80.0,
        start_ms=-1700.0,
        end_ms=100.0,
    )
    ffi = np.asarray(model(disc.frames, eye.fps).ffi)
    before = np.asarray(disc.time) < 0
    return np.asarray(disc.courses["full_angle_deg"])[before], ffi[before]


def angle_at(level, angle, ffi):
    """The angle at which the inhibition first passes a level; NaN where that is never."""
    passed = np.flatnonzero(ffi >= level)
    return angle[passed[0]] if passed.size else np.nan


angles = {}
for name, model in circuits.items():
    angle, ffi = course(model, -0.9, 40.0)
    level = ffi[np.searchsorted(angle, 35.0)]
    angles[name] = [[angle_at(level, *course(model, contrast, speed)) for speed in SPEEDS] for contrast in CONTRASTS]
    print(f"{name}, angle in degrees")
    print("  contrast  " + "".join(f"{f'{speed:g} ms':>8}" for speed in SPEEDS))
    for contrast, row in zip(CONTRASTS, angles[name], strict=True):
        print(f"  {contrast:8g}  " + "".join(f"{value:8.1f}" for value in row))

# %% [markdown]
# ## Side by side on recordings
# The paper's circuit, and one with a graded shunt (B) and a membrane (D), each fitted to the recorded DCMD from one
# start, by a search as short. `lgmd.compare` takes fits to the same data, here in memory; folders of
# results and names of shipped fits do as well. AIC and BIC charge for each free parameter: the least is best.

# %%
conditions = lgmd.load_protocol("dcmd").conditions
circuit = lgmd.preset("balanced", T_s=5, T_sfa=5e-4, sigma1=0.316, tau2=800, T_ffi=20)
free = {"k": (0.05, 3), "tau2": lgmd.Log(20, 3000), "tau3": lgmd.Log(50, 1500), "T_ffi": lgmd.Log(1, 60)}
free |= {"gain": None, "latency": None, "baseline": None}
fits = {}
for name, mechanisms, more in (
    ("none", (), {}),
    ("B and D", ("shunt", "membrane"), {"m": None, "gamma": None, "tau_cell": None}),
):
    fits[name] = lgmd.fit(
        lgmd.LGMD2(circuit, eye=conditions[0].eye, mechanisms=mechanisms),
        conditions,
        lgmd.Free(**free, **more),
        key=jax.random.key(0),
        observation=lgmd.Observation(baseline=5.0, gain=90.0, latency=55.0, smoothing=20.0),
        pixel_points=1,
        cell_points=256,
        descend=1,
        temperatures=(0.2,),
    )
print(lgmd.compare(fits))

# %%
figure, panels = plt.subplots(1, len(conditions), figsize=(9, 2.4), sharey=True, layout="constrained")
for place, (axes, condition) in enumerate(zip(panels, conditions, strict=True)):
    for name, fit in fits.items():
        curve = fit.curves[place]
        axes.plot(curve.time, curve.hard, label=name)
    wanted = fits["none"].curves[place]
    axes.plot(wanted.time, wanted.target, color="black", linewidth=0.8, label="recorded")
    axes.set(title=condition.name.removeprefix("dark approach "), xlim=(-300, 300), xlabel="time (ms)")
panels[0].legend(frameon=False, fontsize=7)

# %% [markdown]
# Longer searches over seven circuits, on these recordings and on the curves of the LGMD2, stand in
# [What each mechanism buys](../docs/model/circuits.md).
