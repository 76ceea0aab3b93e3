# %% [markdown]
# # From fit to robot
# A model becomes a file that proves itself on loading, and one module of NumPy that runs it.

# %%
import contextlib
import io
import pathlib
import tempfile

import imageio.v3 as iio
import matplotlib.pyplot as plt
import numpy as np

import lgmd2jax as lgmd
from lgmd2jax import hard
from lgmd2jax.cli import main

folder = pathlib.Path(tempfile.mkdtemp())
ROBOT_T_SP = 0.65  # the paper's, on the robot
model = lgmd.LGMD2(lgmd.Parameters(T_sp=ROBOT_T_SP, N_sp=4), eye=lgmd.Eye.preset("colias"))
lgmd.save(model, folder / "model.json")
print(f"model.json: {(folder / 'model.json').stat().st_size / 1000:.0f} kB")

# %% [markdown]
# What the robot's camera sees of a ball that rolls towards it, with noise; both models on the same frames.

# %%
ball = next(it for it in lgmd.load_protocol("robot").conditions if it.name == "overhead approach from 20 cm").render()
frames = np.asarray(ball.frames)
robot = hard.load(folder / "model.json")
theirs = robot(frames, fps=30)
ours = model(frames)
for channel in ("mp", "ffi", "smp_adapted", "spikes", "collision"):
    one, other = (np.asarray(getattr(it, channel), float) for it in (ours, theirs))
    print(f"{channel:12} equal to a millionth: {np.allclose(one, other, rtol=1e-6, atol=1e-6 * np.abs(one).max())}")


def show(images):
    """Draw pictures side by side, by their titles."""
    _, axes = plt.subplots(1, len(images), figsize=(8, 8 / len(images)), layout="constrained")
    for panel, (title, image) in zip(axes, images.items(), strict=True):
        panel.imshow(image, cmap="gray", vmin=0, vmax=255)
        panel.set_title(title, fontsize=8)
        panel.axis("off")


show({f"{at:g} ms": frames[int(np.searchsorted(ball.time, at))] for at in (-500, -200, -100, -66.6, -33.3, 0)})

# %% [markdown]
# Frame by frame, as on the robot. The library stamps every response with the frame that caused it.

# %%
robot.reset()
alarms = [time for time, frame in zip(ball.time, frames, strict=True) if robot.step(frame).collision]
print("alarm at", ", ".join(f"{time:.0f}" for time in alarms), "ms")

# %% [markdown]
# A file that was altered is refused, because its test vector no longer comes out.

# %%
altered = (folder / "model.json").read_text().replace('"k": 1.0', '"k": 1.1')
(folder / "altered.json").write_text(altered)
try:
    hard.load(folder / "altered.json")
except ValueError as error:
    print(str(error).replace(f"{folder}/", ""))

# %% [markdown]
# A clip, with trace and alarm drawn on it: `lgmd2jax respond` does this for any video.

# %%
clip, overlaid = folder / "ball.mp4", folder / "ball-alarm.mp4"
iio.imwrite(
    clip, np.repeat(frames.astype(np.uint8)[..., None], 3, axis=-1)[:, :, :98], plugin="pyav", codec="libx264", fps=30
)
command = ["respond", str(clip), "--model", "preset:lgmd2", "--set", f"T_sp={ROBOT_T_SP}", "--overlay", str(overlaid)]
command += ["--csv", str(folder / "ball.csv"), "--figure", str(folder / "ball.png")]
with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
    status = main(command)
pictures = iio.imread(overlaid, plugin="pyav")
print("exit status", status, "-", len(pictures), "frames")
show({f"frame {at}": pictures[at] for at in range(len(pictures) - 24, len(pictures) - 12, 3)})
