"""Clips of one raster side by side, and the evidence for an alarm over each."""

from collections.abc import Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Real

from lgmd2jax._compute.batching import each
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.stages import Record
from lgmd2jax.alarms._clip import LabelledClip
from lgmd2jax.alarms._evidence import evidence

Sums = tuple[Float[Array, "_clip _time"], Float[Array, "_clip _time"]]
_SHORT = 1023  # frames up to which clips of all lengths share a batch; of longer ones those of like lengths do


class ClipBatch(eqx.Module):
    """Clips held at their last frame up to a common length, with which frames lie in each window and which are silent.

    `members`: which of the clips these are. `has_window`: for each clip which of the windows there are. `has_silence`:
    which clips must be silent in some frames.
    """

    frames: Real[Array, "clip time row col"]
    interval: Float[Array, "clip time"]
    windows: Bool[Array, "clip window time"]
    silent: Bool[Array, "clip time"]
    members: tuple[int, ...] = eqx.field(static=True)
    has_window: tuple[tuple[bool, ...], ...] = eqx.field(static=True)
    has_silence: tuple[bool, ...] = eqx.field(static=True)

    def sums(self, model: LGMD2) -> Sums:
        """MP and F of every clip. Pixels compute in float32; whole grey levels are kept as such until then."""
        return self.recorded(model, None)[0]

    def recorded(self, model: LGMD2, record: Record | None) -> tuple[Sums, Any]:
        """MP and F of every clip, and what is recorded of the layers in every frame."""
        clips = self.frames, self.interval
        return each(lambda clip: model.sums(clip[0].astype(jnp.float32), clip[1], record), clips)

    def traces(self, model: LGMD2, sums: Sums, N_sp: int) -> Float[Array, "clip time"]:
        """The evidence for an alarm in every frame."""
        pixels = self.frames[0, 0].size

        def potential(sums, interval):
            return model.respond(sums, interval, pixels).smp_adapted

        u = jax.vmap(potential)(sums, self.interval)
        return evidence(u, model.parameters.sigma_sp, N_sp, model.N_ts)


def batches_of(clips: Sequence[LabelledClip]) -> tuple[ClipBatch, ...]:
    """All clips, those of a raster and of like lengths in one batch."""
    alike: dict[tuple, list[int]] = {}
    for number, clip in enumerate(clips):
        length = max(len(clip.frames), _SHORT).bit_length()
        alike.setdefault((*clip.frames.shape[1:], clip.frames.dtype, length), []).append(number)
    return tuple(_batch([clips[member] for member in members], tuple(members)) for members in alike.values())


def _batch(clips: Sequence[LabelledClip], members: tuple[int, ...]) -> ClipBatch:
    length = max(len(clip.frames) for clip in clips)
    windows = np.zeros((len(clips), max(len(clip.windows) for clip in clips), length), bool)
    silent = np.zeros((len(clips), length), bool)
    for number, clip in enumerate(clips):
        windows[number, : len(clip.windows), : len(clip.frames)] = clip.in_windows()
        silent[number, : len(clip.frames)] = clip.in_silence()
    frames = [np.pad(clip.frames, [(0, length - len(clip.frames)), (0, 0), (0, 0)], mode="edge") for clip in clips]
    intervals = [np.pad(clip.interval, (0, length - len(clip.frames)), mode="edge") for clip in clips]
    return ClipBatch(
        frames=jnp.asarray(np.stack(frames)),
        interval=jnp.asarray(np.stack(intervals), dtype=float),
        windows=jnp.asarray(windows),
        silent=jnp.asarray(silent),
        members=members,
        has_window=tuple(tuple(map(bool, row)) for row in np.asarray(windows.any(axis=2))),
        has_silence=tuple(map(bool, np.asarray(silent.any(axis=1)))),
    )
