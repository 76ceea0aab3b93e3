"""Why a model is wrong on a clip: what kept it from an alarm that was wanted, and what drove a false one."""

import math
from typing import Literal, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.pixels import Layers
from lgmd2jax._network.stages import Sums
from lgmd2jax._signals import stretches
from lgmd2jax.alarms._clip import ClipLabels, Stretch
from lgmd2jax.alarms._evidence import evidence

_LATE_MS = 1000.0  # an alarm so soon after a window is one that came late
_BEFORE = 5  # frames up to a false alarm that tell where in the field it came from

Why = Literal["inhibited", "late", "weak"]


class Drive(NamedTuple):
    """What acts on the cell in each frame of a clip.

    - `uninhibited`: the evidence for an alarm if nothing inhibited the cell.
    - `inhibited`: whether the delayed inhibition is above its threshold. That shuts the gate; it halves the excitation
      of a cell with a shunt, or more.
    - `field`: the share of the field in which the S layer passes T_s.
    - `row`, `col`: where the middle of that part lies, from 0 at the top and the left to 1.
    """

    uninhibited: Float[Array | np.ndarray, "*clip time"]
    inhibited: Bool[Array | np.ndarray, "*clip time"]
    field: Float[Array | np.ndarray, "*clip time"]
    row: Float[Array | np.ndarray, "*clip time"]
    col: Float[Array | np.ndarray, "*clip time"]


class Miss(NamedTuple):
    """A window without an alarm.

    - `why`: `"inhibited"` where the alarm would have come without inhibition, `"late"` where it came within a second
      after the window, `"weak"` where the excitation would not have sufficed even without inhibition.
    - `inhibited`: the share of the window's frames in which the cell was inhibited.
    - `evidence`: the largest in the window. `late_ms`: from the window's end to the alarm; NaN where none came.
    """

    window: Stretch
    why: Why
    inhibited: float
    evidence: float
    late_ms: float


class FalseAlarm(NamedTuple):
    """An alarm in a silence, and the part of the field that drove it in the frames before.

    `frames`: first and last. `field`, `row`, `col`: as in `Drive`, `field` where it was largest.
    """

    frames: Stretch
    field: float
    row: float
    col: float


def active_part(layers: Layers) -> tuple[Array, Array, Array]:
    """How much of the field passes T_s, and where its middle lies: `field`, `row` and `col` of a `Drive`."""
    active = (layers.s_gated != 0).astype(layers.s_gated.dtype)
    rows, cols = active.shape
    total = jnp.maximum(active.sum(), 1)
    row = (active.sum(axis=1) * (jnp.arange(rows) + 0.5)).sum() / (total * rows)
    col = (active.sum(axis=0) * (jnp.arange(cols) + 0.5)).sum() / (total * cols)
    return active.mean(), row, col


def drive_of(
    model: LGMD2,
    mp: Float[Array, " time"],
    ffi: Float[Array, " time"],
    part: tuple[Array, Array, Array],
    interval: Float[Array, " time"],
    pixels: int,
    N_sp: int,
) -> Drive:
    """What acts on the cell over a clip.

    **Arguments:** `mp`, `ffi`: MP and Fbar (eqs 11, 14). `part`: what `active_part` says of each frame. `interval`: ms.
    `pixels`: of a frame.
    """
    u = model.respond(Sums(mp, jnp.zeros_like(mp)), interval, pixels).smp_adapted
    uninhibited = evidence(u, model.parameters.sigma_sp, N_sp, model.N_ts)
    return Drive(uninhibited, ffi > model.cell.inhibited_from, *part)


def misses(clip: ClipLabels, trace: Float[np.ndarray, " time"], drive: Drive, T_sp: float) -> tuple[Miss, ...]:
    """Why each window without an alarm has none.

    **Arguments:** `trace`: the evidence for an alarm.
    """
    found = []
    for window, inside in zip(clip.windows, clip.in_windows(), strict=True):
        if (trace[inside] >= T_sp).any():
            continue
        end = clip.time[inside][-1]
        after = np.flatnonzero((trace >= T_sp) & (clip.time > end) & (clip.time <= end + _LATE_MS))
        late = float(clip.time[after[0]] - end) if len(after) else math.nan
        would_do = bool((np.asarray(drive.uninhibited)[inside] >= T_sp).any())
        why: Why = "inhibited" if would_do else "weak" if math.isnan(late) else "late"
        shut = float(np.asarray(drive.inhibited)[inside].mean())
        found.append(Miss(window, why, shut, float(trace[inside].max()), late))
    return tuple(found)


def false_alarms(
    clip: ClipLabels, trace: Float[np.ndarray, " time"], drive: Drive, T_sp: float
) -> tuple[FalseAlarm, ...]:
    """Where in the field each false alarm came from.

    **Arguments:** `trace`: the evidence for an alarm.
    """
    found = []
    for first, last in stretches((trace >= T_sp) & clip.in_silence()):
        before = slice(max(0, first - _BEFORE + 1), first + 1)
        field = np.asarray(drive.field, float)[before]
        weights = field / max(field.sum(), 1e-9)
        row, col = (float((weights * np.asarray(place)[before]).sum()) for place in (drive.row, drive.col))
        found.append(FalseAlarm((int(clip.index[first]), int(clip.index[last])), float(field.max()), row, col))
    return tuple(found)
