# %% [markdown]
# # What one more mechanism would buy
# Of the 22 response properties the best model of this circuit holds 16 ([which exclude each other, and
# why](../fits/lgmd2/properties.md)). Two that it misses hang on what the feed-forward inhibition counts. Row 2: the
# peak comes alpha l/|v| - delta before the collision, and here delta has the wrong sign. Row 18: the angle at the peak
# must not hang on contrast. The smallest mechanisms that free them are tried here, outside of the library.

# %%
import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from scipy.stats import qmc

import lgmd2jax as lgmd
from benchmarks.properties import CELL, EYE
from lgmd2jax._characterise.curves import curves_of
from lgmd2jax._characterise.exam import exam_of, sums_of
from lgmd2jax._characterise.measurements import measure, result_of
from lgmd2jax._characterise.properties import ROWS
from lgmd2jax._network.stages import Sums
from notebooks import plots

jax.config.update("jax_enable_x64", True)
exam = exam_of(EYE)

# %% [markdown]
# The cell sees two numbers a frame, MP and F, and its gate closes where the delayed F passes T_ffi. F is the mean of
# |P|: edge length times speed times step of luminance, so that contrast is in it. Two candidates, in percent:
#
# - **count**: the share of pixels with |P| above T_p, 9.3 grey levels, more than noise gives. An edge of this eye moves
#   less than a pixel a frame, so that the count is its length in pixels: neither contrast nor speed is left in it.
# - **saturating**: the mean of |P|/(|P| + 20).
#
# And **late**: all of it, MP and F, is seen 40 ms later, as by photoreceptors with a dead time.

# %%
T_P, HALF, LATE = 9.26, 20.0, 40.0  # grey levels at 100 frames per second; ms


def inhibition(of):
    """F of every trial. What counts a frame goes with its length; T_ffi is scaled so by the exam."""

    def f(trial):
        share = EYE.fps / trial.fps
        frames = exam.frames(trial)
        change = np.abs(np.diff(frames, axis=0, prepend=frames[:1])) / share
        return share * 100 * of(change).mean(axis=(1, 2), dtype=float)

    return [np.stack([f(trial) for trial in group]) for group in exam.groups]


def later(channels):
    """Moved back by the dead time, with rest before it."""
    counts = [round(LATE * group[0].fps / 1000) for group in exam.groups]
    return [np.pad(it, ((0, 0), (n, 0)))[:, : it.shape[1]] for n, it in zip(counts, channels, strict=True)]


pixels = {
    "the best of the plain search": lgmd.Parameters(
        theta1=0.04044, theta3=0.003177, tau1=20.65, w_bias=0.1206, sigma1=0.1581, T_s=4.111
    ),
    "a stage that the count prefers": lgmd.Parameters(
        theta1=0.0317, theta3=0.0033, tau1=10.26, w_bias=0.0953, sigma1=0.1988, T_s=3.277
    ),
}
counted, saturated = inhibition(lambda p: p > T_P), inhibition(lambda p: p / (p + HALF))
stages = {}
for name, parameters in pixels.items():
    model = lgmd.LGMD2(parameters, eye=EYE)
    mp, plain = ([np.asarray(it) for it in channel] for channel in zip(*sums_of(exam, model), strict=True))
    stages[name] = model, mp, plain

# %% [markdown]
# For each mechanism and both sets of pixel parameters the same search: 512 cells, a half at random with three that
# longer searches found, one for each way to count, and a half near the best of these. A row that fails counts half of
# its lines that hold.

# %%
starts = [
    {"tau2": 28.25, "tau3": 282.6, "T_ffi": 2.308, "T_sfa": 6.53e-3, "k": 0.2684},
    {"tau2": 46.0, "tau3": 207.5, "T_ffi": 1.572, "T_sfa": 5.7e-4, "k": 0.2834},
    {"tau2": 25.81, "tau3": 1045.0, "T_ffi": 11.03, "T_sfa": 9e-4, "k": 2.525},
]


@eqx.filter_jit
def examined(sums, model, cells):
    def one(z):
        parameters, _ = CELL.insert(model.parameters, lgmd.Observation(), z)
        return measure(curves_of(exam, sums, dataclasses.replace(model, parameters=parameters)))

    return jax.lax.map(one, cells, batch_size=16)


def scores(them):
    lines = [
        np.mean([(x >= line.low) & (x <= line.high) for line, x in zip(row.lines, values.T, strict=True)], axis=0)
        for row, values in zip(ROWS, them.values, strict=True)
    ]
    return np.where(them.passed, 1, 0.5 * np.stack(lines, axis=1)).sum(axis=1)


def chosen(them, i):
    return jax.tree.map(lambda values: values[i], them)


def searched(sums, model):
    """The highest score, and what is measured on the model that has it."""
    rng, found = np.random.default_rng(0), []
    known = np.array([[float(it.place(start[it.name])) for it in CELL.freedoms] for start in starts])
    z = np.vstack([known, qmc.Sobol(len(CELL), rng=rng).random(256)[len(known) :]])
    for _ in range(2):
        them = jax.device_get(examined(sums, model, jnp.asarray(z)))
        score = scores(them)
        found.append((score.max(), chosen(them, score.argmax())))
        parents = z[rng.choice(np.argsort(-score)[:8], 256)]
        steps = rng.choice([0.01, 0.04, 0.12], (256, 1)) * rng.standard_normal(parents.shape)
        z = np.clip(parents + steps, 0, 1)
    return max(found, key=lambda it: it[0])


def same(channels):
    return channels


mechanisms = {
    "mean |P|": (None, same),
    "saturating": (saturated, same),
    "count": (counted, same),
    "mean |P|, late": (None, later),
    "count, late": (counted, later),
}
found = {}
for mechanism, (f, delay) in mechanisms.items():
    runs = [
        searched(tuple(map(Sums, delay(mp), delay(plain if f is None else f))), model)
        for model, mp, plain in stages.values()
    ]
    found[mechanism] = result_of(exam, "LGMD2", max(runs, key=lambda run: run[0])[1])

for mechanism, it in found.items():
    missed = ", ".join(str(row.number) for row in it.rows if not row.passed)
    (alpha, delta), (mean, spread) = it[2].values, it[3].values
    print(f"{mechanism}: {it.passed} of 22, without {missed}")
    print(f"   row 2: alpha {alpha:.1f}, delta {delta:.0f} ms; row 3: angle {mean:.0f} +- {spread:.1f} deg")
    print(f"   row 18: over contrasts the angle lies within {it[18].values[2]:.1f} deg")

# %% [markdown]
# Looms of four contrasts, and when the peak comes. With the mean of |P| the weaker the contrast the later the gate
# closes; with the count it closes on all of them at one time.

# %%
plots.gates(found, by_contrast=("mean |P|", "count"), by_speed=("mean |P|", "count", "count, late"))

# %% [markdown]
# ## What it buys
# - **Counting pixels** instead of adding up |P| frees row 18, beside row 3: one threshold angle, whatever the contrast.
#   It brings 17 (changes of light), 19 (half the light) and 22 (another frame rate) as well; 13 (translation) and 16
#   (gratings) are lost in the model found here: 18 rows instead of 16. It costs one parameter, T_p.
# - **Saturation** keeps a part of the contrast: the best it gives peaks too late to have one threshold angle.
# - **A dead time** of all signals moves the line of peak times, so that delta gets its sign. With the mean of |P| 40 ms
#   are too short; with the count row 2 holds, beside 3 and 18. There are 18 of 22 as before, for 20 (form and texture)
#   is lost.
# - **Row 5**, the width of the peak, no candidate touches: its fall is the gate's, one frame long. A gate that closes
#   by degrees would be the next to try.
#
# None of this is in the model: the network stays that of the paper.
