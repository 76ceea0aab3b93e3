# %% [markdown]
# # Your clips
# What the network makes of a video, how a clip is labelled and judged, and how a model is fitted to raise its alarms in
# time. The same is done by `lgmd2jax respond`, `watch` and `fit` on the command line.

# %%
import os
import pathlib
import tempfile

import imageio.v3 as iio
import jax
import matplotlib.pyplot as plt
import numpy as np

import lgmd2jax as lgmd
from lgmd2jax.cli import main

jax.config.update("jax_enable_x64", True)  # fits want double precision
os.chdir(tempfile.mkdtemp())

# %% [markdown]
# ## A clip
# Here the clip is rendered, so that its collision is known: a dark ball on a camera of 30 frames a second, with noise.
# Any video that ffmpeg reads, or a folder of images, stands in its place.

# %%
camera = lgmd.Eye(rows=80, cols=144, degrees_per_pixel=0.5, fps=30.0, projection="pinhole")
ball = lgmd.stimuli.looming(camera, l_over_v=60.0, contrast=-0.7, start_angle=3, stop_angle=50, start_ms=-2500)
noise = np.random.default_rng(0).normal(0, 2, ball.frames.shape)
frames = np.clip(np.asarray(ball.frames) + noise, 0, 255).astype(np.uint8)
contact = int(np.searchsorted(ball.time, 0))
iio.imwrite("ball.mp4", np.repeat(frames[..., None], 3, axis=-1), plugin="pyav", codec="libx264", fps=30)
print(f"{len(frames)} frames; contact in frame {contact}")

# %% [markdown]
# `lgmd2jax respond ball.mp4` writes the response as a table and a figure.

# %%
status = main(["respond", "ball.mp4", "--resize", "72"])
print(pathlib.Path("ball.csv").read_text()[:200], "...", sep="")

# %% [markdown]
# ## Labels
# A file of labels says in which frames an alarm must be raised, and where contact is. All else must be silent. The
# `eye` is what clips are resized to.

# %%
pathlib.Path("mine.toml").write_text(f"""\
[eye]
rows = 20
cols = 36
degrees_per_pixel = 1.95
fps = 30

[[clip]]
file = "ball.mp4"
alarm = [[{contact - 30}, {contact}]]
contact = {contact}
""")
status = main(["watch", "mine.toml", "--model", "video"])

# %% [markdown]
# `video` is a shipped fit. The same in Python, with the evidence for an alarm in every frame:

# %%
labels = lgmd.alarms.load_labels("mine.toml")
recipe = lgmd.alarms.load_recipe("video")
clips = labels.load()
evaluation = lgmd.alarms.evaluate(recipe.model, clips)
figure, axes = plt.subplots(figsize=(7, 2.5), layout="constrained")
axes.plot(evaluation.evidence[0], label="evidence")
axes.axhline(evaluation.T_sp, color="gray", linewidth=0.8, label="T_sp: alarm from here on")
axes.axvspan(*clips[0].windows[0], alpha=0.2, label="an alarm is wanted")
axes.set(xlabel="frame")
axes.legend(frameon=False)

# %% [markdown]
# ## A fit of alarms
# Your clips beside rendered ones, whose labels are known by geometry. Twelve are too few for a detector;
# `lgmd2jax fit video --clips mine.toml` takes hundreds, and judges on clips that the fit has not seen.

# %%
rendered = list(lgmd.alarms.Rendering(count=12).clips(labels.eye))
fit = lgmd.alarms.fit(
    recipe.model,
    [*clips, *rendered],
    recipe.free,
    key=jax.random.key(0),
    pixel_points=4,
    cell_points=64,
    descend=0,
    generations=0,
)
before, after = (lgmd.alarms.evaluate(model, [*clips, *rendered]).score() for model in (recipe.model, fit.model))
print(f"where the search sets out: {before}")
print(f"fitted: {after}")
