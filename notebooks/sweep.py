# %% [markdown]
# # Sweeps
# What the cell answers over grids of stimuli and of parameters: labelled arrays, surfaces, and their slopes.

# %%
import pathlib
import tempfile

import jax
import numpy as np
import xarray

import lgmd2jax as lgmd
from notebooks import plots

eye = lgmd.Eye(rows=48, cols=64, degrees_per_pixel=2.0, fps=30.0)
model = lgmd.LGMD2()

# %% [markdown]
# Every list is an axis; all else stays fixed. One compiled program renders each loom, runs the network and keeps five
# numbers of the response, with units in the attributes.

# %%
grid = {"contrast": [-0.1, -0.15, -0.2, -0.4, -0.8], "l_over_v": [20, 40, 80, 160]}
looms = lgmd.sweep(model, lgmd.stimuli.looming, eye, **grid)
print(looms)
looms.peak.to_pandas().round(3)

# %% [markdown]
# Labels say what is meant: where is the first alarm, in ms before the collision, of the discs that come slowly?

# %%
looms.first_alarm.sel(l_over_v=[80, 160]).to_pandas().round(0)

# %% [markdown]
# ## The paper's surface
# Fu et al. (Fig. 6) show squares of several contrasts whose edges move outward at constant speeds, on a screen of
# 240 x 320 pixels. They say: *the peak grows with contrast, most where the edge is slow, and the influence of contrast
# shrinks as the speed grows.* Holds, but for steps of thousandths downwards where the gate cuts the peak a frame
# earlier. The threshold T_s of the S layer keeps contrast .1 at rest. Red: the spiking thresholds.

# %%
speeds = np.geomspace(30, 240, 7)
paper = lgmd.sweep(
    model,
    lgmd.stimuli.looming,
    lgmd.Eye.preset("paper"),
    contrast=-np.linspace(0.1, 1, 10),
    growth_px=speeds,
    start_radius_px=0.6,
    stop_radius_px=110,
    shape="square",
    background=200,
)
strong = paper.peak.sel(contrast=slice(-0.2, -1))
ranges = (strong.max("contrast") - strong.min("contrast")).values
steps = strong.diff("contrast")
print(f"from one contrast to the next the peak changes by {float(steps.min()):+.3f} to {float(steps.max()):+.3f}")
print("range of peaks over contrasts .2 to 1:", ", ".join(f"{it:.3f}" for it in ranges))
print("at edges of", ", ".join(f"{it:.0f}" for it in speeds), "px/s; it shrinks:", bool(np.all(np.diff(ranges) < 0)))
plots.surface(paper, "peak", "contrast and speed of the edge", {"1 spike": 0.78, "2 spikes": 0.88})

# %% [markdown]
# ## A parameter map
# Parameters of the model are axes as well. What makes the cell choose dark objects before light ones? Here the weight
# theta2 of the OFF pathway beside an ON pathway of weight 1, and the delay tau1 of the lateral flow, at 100 frames per
# second, with T_ffi so high that the gate cuts neither. The index is 1 where the dark loom alone is answered, 0 where
# the light one is answered as much.

# %%
choice = lgmd.sweep(
    lgmd.LGMD2(lgmd.preset("balanced")),
    lgmd.stimuli.looming,
    lgmd.Eye.preset("locust"),
    parameters={"theta2": np.linspace(0, 2, 9), "tau1": np.geomspace(5, 50, 8), "T_ffi": 30},
    contrast=[-0.9, 0.9],
    background=110,
    l_over_v=40,
    start_ms=-1500,
)
plots.surface(choice, "integral", "dark or light", index="contrast")

# %% [markdown]
# The weight decides, the delay shifts the balance a little. But no weight silences the light loom while ON counts: the
# index only creeps up. Table I takes theta1 = 0.

# %% [markdown]
# ## One threshold angle
# The locust's LGMD peaks a fixed delay after the object has reached one angle, whatever its contrast and speed. Here
# the full angle of a disc 35 ms before the peak, sought up to the end of the motion: by the paper's circuit, and by the
# fitted one, whose inhibition codes size. `python -m benchmarks.threshold_angle` makes [a finer surface of 1,000
# looms](../fits/lgmd2/surface.png).

# %%
fitted = lgmd.load("fits/lgmd2/model.json")
table = lgmd.at_frame_rate(lgmd.LGMD2(eye=lgmd.Eye(48, 64, 2.0, fps=30.0)), fitted.eye.fps)
for name, circuit in {"Table I": table, "fitted": fitted}.items():
    shown = {"contrast": [-0.3, -0.6, -1.0], "l_over_v": [20, 40, 80], "stop_angle": 80, "channels": ["smp_adapted"]}
    curves = lgmd.sweep(circuit, lgmd.stimuli.looming, fitted.eye, **shown).smp_adapted
    stop = -curves.l_over_v / np.tan(np.radians(80 / 2))
    peak_time = curves.where(curves.time <= stop).idxmax("time")
    angle = 2 * np.degrees(np.arctan2(curves.l_over_v, 35 - peak_time))
    print(f"{name}: {float(angle.min()):.0f} to {float(angle.max()):.0f} degrees")
    print(angle.transpose("contrast", "l_over_v").to_pandas().round(0))

# %% [markdown]
# ## Slopes of a surface
# `surfaces` gives the same grid as plain JAX arrays, so that a number of the whole surface has a gradient in every
# parameter. Soft thresholds have slopes; beside them a central difference.

# %%
small = lgmd.Eye(rows=24, cols=32, degrees_per_pixel=4.0, fps=30.0)


def mean_peak(parameters):
    soft = lgmd.LGMD2(parameters, lgmd.Soft())
    shown = {"contrast": [-0.2, -0.4, -0.8], "l_over_v": [40, 80, 160]}
    return lgmd.surfaces(soft, lgmd.stimuli.looming, small, start_ms=-2000, **shown)["peak"].mean()


with jax.enable_x64(True):
    slopes = jax.jit(jax.grad(mean_peak))(lgmd.Parameters())
    value, h = jax.jit(mean_peak), 1e-4
    print(f"mean peak of nine looms: {value(lgmd.Parameters()):.4f}")
    for name in ("k", "T_s", "w_bias"):
        at = getattr(lgmd.Parameters(), name)
        up, down = (value(lgmd.Parameters(**{name: at + step})) for step in (h, -h))
        print(f"slope in {name:6}: {getattr(slopes, name):+.5f}, by differences {(up - down) / (2 * h):+.5f}")

# %% [markdown]
# ## Large sweeps
# A grid is cut into blocks, so that memory does not grow with it. With `store=` each block is written as it is
# finished: the same line, given again after a stop or a kill, computes only what is missing. `client=` sends blocks to
# the workers of a Dask cluster. `lgmd2jax sweep RECIPE` does all of this from a file, as `fits/contrast_speed.toml`.

# %%
store = pathlib.Path(tempfile.mkdtemp()) / "looms.zarr"
stored = lgmd.sweep(model, lgmd.stimuli.looming, eye, **grid, store=store, block=4)
print("blocks of", stored.peak.encoding["chunks"], "- the same numbers:", bool((stored.peak == looms.peak).all()))
print("read later:", xarray.open_zarr(store, consolidated=False).peak.sel(contrast=-0.15, l_over_v=80).values.round(3))
try:
    lgmd.sweep(lgmd.LGMD2(lgmd.Parameters(k=2.0)), lgmd.stimuli.looming, eye, **grid, store=store, block=4)
except ValueError as error:
    print(str(error).replace(f"{store.parent}/", ""))
