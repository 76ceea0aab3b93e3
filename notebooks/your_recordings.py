# %% [markdown]
# # Your recordings: from the file to alpha, delta and a fitted neuron
# Spike times in whatever files a laboratory has, CSV, Excel, Matlab, NWB, Neo or an export of Spike2, become trials.
# These tell the law of peak times (collision - peak = alpha l/|v| - delta) without any model, and are what a model is
# fitted to. Here the files are made up, with alpha 4.4 and delta 18.7 ms, so that the answers are known.

# %%
import csv
import os
import pathlib
import tempfile

import jax
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

import lgmd2jax as lgmd
from lgmd2jax.cli import main

jax.config.update("jax_enable_x64", True)  # fits want double precision
os.chdir(tempfile.mkdtemp())
folder = pathlib.Path("recordings")
folder.mkdir()
rng = np.random.default_rng(1)
time = np.arange(-800.0, 400.0)  # ms from collision
trials, spikes = [], []
for animal, gain in {"A": 150, "B": 110, "C": 190, "noise": 0}.items():
    for trial in range(24):
        l_over_v = (10, 20, 30, 40)[trial % 4]
        rate = 5 + gain * np.exp(-0.5 * ((time + 4.4 * l_over_v - 18.7) / 40) ** 2) if gain else np.full(time.shape, 80)
        impact = 50 + 10 * trial  # s, on the clock of the session
        trials.append([animal, trial, l_over_v, impact, impact - 0.8, impact + 0.4])
        spikes += [[animal, trial, f"{impact + t / 1000:.5f}"] for t in time[rng.random(time.size) < rate / 1000]]
for name, header, rows in (
    ("trials.csv", ["animal", "trial", "l_over_v_ms", "impact_s", "start_s", "end_s"], trials),
    ("spikes.csv", ["animal", "trial", "spike_s"], spikes),
):
    with open(folder / name, "w", newline="") as file:
        csv.writer(file).writerows([header, *rows])
    print((folder / name).read_text()[:120].rpartition("\n")[0], "...", sep="\n")

# %% [markdown]
# Reading them is one call. Names of columns tell what is what, with their units; what a file does not tell is asked
# for. A unit is never guessed: seconds cannot pass as milliseconds.

# %%
recorded = lgmd.load_trials(folder)
print(len(recorded), "trials of", ", ".join(recorded.animals), "at", *recorded.conditions)
pathlib.Path("unknown.csv").write_text("animal,trial,l_over_v_ms,time\nA,1,20,-0.35\nA,1,20,-0.04\n")
try:
    lgmd.load_trials("unknown.csv")
except ValueError as error:
    print(error)

# %% [markdown]
# **The law, straight from the data**, as `lgmd2jax looming FOLDER` prints it: each animal by itself and all of them,
# with intervals by bootstrap over trials, and what quality control took out by which rule.

# %%
law = recorded.looming_law()
print(law.summary())

# %%
figure, axes = plt.subplots(figsize=(5, 3.5), layout="constrained")
axes.set(xlabel="l/|v| (ms)", ylabel="peak before collision (ms)")
for name, times in [*law.animals.items(), ("all", law.pooled)]:
    speeds = np.array(list(times.peak_ms))
    (line,) = axes.plot(speeds, times.alpha.value * speeds - times.delta_ms.value, label=f"{name}: {times.alpha}")
    axes.plot(speeds, [-peak for peak in times.peak_ms.values()], "o", color=line.get_color())
axes.legend(title="alpha", frameon=False)

# %% [markdown]
# **What was recorded, and a protocol of it.** `lgmd2jax import` shows what it found and writes the looms as a protocol
# with the spikes as targets, and the recipe of a fit. What no file can know, such as the frame rate of the screen and
# the angle at which the loom stopped, is an option, and what is assumed is said.

# %%
options = ["--fps", "60", "--stop-angle", "80", "--contrast", "-0.9", "--background", "200"]
status = main(["import", "recordings", "-o", "mine", *options])
Image.open("mine/trials.png").convert("RGB").quantize(32)

# %% [markdown]
# **A fit of every animal.** `lgmd2jax fit mine/fit.toml` fits the circuit with a shunt to each animal by itself; here
# the same in Python, with fewer parameters and fewer starts. The peaks were 150, 110 and 190 spikes/s, and the
# gains are to stand in about this ratio.

# %%
conditions = lgmd.load_protocol("mine/protocol.toml").conditions
circuit = lgmd.preset("balanced", tau1=15, T_s=3, T_sfa=2e-3, sigma1=0.316, tau2=800, T_ffi=60)
model = lgmd.LGMD2(circuit, eye=conditions[0].eye, mechanisms=("shunt",))
free = lgmd.Free(k=(0.05, 3), tau3=lgmd.Log(50, 1500), baseline=(0, 20), gain=(10, 600), latency=(0, 120))
animals = lgmd.fit_each(
    model,
    conditions,
    free,
    by="animal",
    key=jax.random.key(0),
    observation=lgmd.Observation(smoothing=20.0),
    pixel_points=1,
    cell_points=256,
    descend=1,
    temperatures=(0.2, 0.05),
)
print(animals.summary())
