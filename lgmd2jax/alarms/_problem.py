"""What a fit of alarms searches: the largest evidence in every window and every silence, at a point of the unit box."""

from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._targets.observation import Observation
from lgmd2jax.alarms._clip import LabelledClip
from lgmd2jax.alarms._clip_batch import ClipBatch, Sums, batches_of
from lgmd2jax.alarms._evidence import NEVER
from lgmd2jax.fitting import Free
from lgmd2jax.fitting._search.space import Space

# Shortfalls are counted from a margin that no model has, U' lying in [.5, 1), so that the descent never rests.
_GOAL = 0.25
_SMOOTH = 0.02  # at temperature 1: within so much of U' frames count alike in a soft maximum


class Event(NamedTuple):
    """A window of a clip, in which an alarm is wanted, or all silences of a clip, with what an error there weighs."""

    clip: int
    wanted: bool
    weight: float


class AlarmProblem(Space[LGMD2]):
    """Labelled clips and what is free. `T_sp` is among it."""

    batches: tuple[ClipBatch, ...]
    events: tuple[Event, ...] = eqx.field(static=True)
    N_sp: int = eqx.field(static=True)

    @property
    def cell_entries(self) -> tuple[int, ...]:
        """The entries of a point that a search over the cell moves: all but T_sp, whose best value is known."""
        return tuple(i for i in self.cell_indices if i != self.threshold)

    @property
    def threshold(self) -> int:
        """Where T_sp stands in a point."""
        return self.free.names.index("T_sp")

    @property
    def wanted(self) -> Bool[np.ndarray, " event"]:
        """Which events want an alarm."""
        return np.array([event.wanted for event in self.events])

    def own_events(self) -> dict[int, Bool[np.ndarray, " event"]]:
        """Which events belong to each clip that has any, by the clip's number."""
        owners = np.array([event.clip for event in self.events])
        return {int(clip): owners == clip for clip in np.unique(owners)}

    @property
    def weights(self) -> Float[np.ndarray, " event"]:
        """What each event weighs."""
        return np.array([event.weight for event in self.events], float)

    @property
    def scale(self) -> float:
        """The norm of the factors of all shortfalls."""
        return float(np.sqrt(self.weights.sum()))

    def sums(self, model: LGMD2) -> tuple[Sums, ...]:
        """MP and F of every clip: all that the cell sees."""
        return tuple(batch.sums(model) for batch in self.batches)

    def peaks(
        self, model: LGMD2, sums: Sequence[Sums], smooth: Float[Array, ""] | None = None
    ) -> Float[Array, " event"]:
        """The largest evidence in each event; a soft maximum, of frames within `smooth` of it, where that is given."""
        peaks = []
        for batch, its_sums in zip(self.batches, sums, strict=True):
            trace = batch.traces(model, its_sums, self.N_sp)
            peaks.append(_largest(trace[:, None], batch.windows, smooth)[np.array(batch.has_window, bool)])
            peaks.append(_largest(trace, batch.silent, smooth)[np.array(batch.has_silence, bool)])
        return jnp.concatenate(peaks)

    def residuals(
        self, z: Float[Array | np.ndarray, " free"], temperature: Float[Array, ""] | None
    ) -> Float[Array, " event"]:
        """How much each event's margin falls short of the goal, squared so that the worst rules the sum of squares."""
        model, _ = self.at(z, temperature)
        peaks = self.peaks(model, self.sums(model), None if temperature is None else _SMOOTH * temperature)
        margin = jnp.where(self.wanted, 1.0, -1.0) * (peaks - model.parameters.T_sp)
        return jnp.sqrt(self.weights) * jnp.square(jnp.maximum(_GOAL - margin, 0) / _GOAL)


def _largest(trace: Array, among: Array, smooth: Float[Array, ""] | None) -> Array:
    top = jnp.where(among, trace, NEVER).max(axis=-1)
    if smooth is None:
        return top
    shares = jnp.where(among, jnp.exp((trace - jax.lax.stop_gradient(top)[..., None]) / smooth), 0)
    total = shares.sum(axis=-1)
    return (shares * trace).sum(axis=-1) / jnp.where(total > 0, total, 1.0)


def problem_of(
    model: LGMD2, free: Free, clips: Sequence[LabelledClip], miss: float, false_alarm: float
) -> AlarmProblem:
    """The problem of labelled clips.

    **Arguments:** `miss`, `false_alarm`: what it costs to miss a window, and to break a clip's silence.
    """
    batches, events = batches_of(clips), []
    for batch in batches:
        for member, has_window in zip(batch.members, batch.has_window, strict=True):
            events += [Event(member, True, miss)] * sum(has_window)
        for member, has_silence in zip(batch.members, batch.has_silence, strict=True):
            events += [Event(member, False, false_alarm)] * has_silence
    return AlarmProblem(model, Observation(), free, batches, tuple(events), round(float(model.parameters.N_sp)))
