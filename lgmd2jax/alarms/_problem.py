"""What a fit of alarms searches: the largest evidence in every window and every silence, at a point of the unit box."""

from collections.abc import Collection, Sequence
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
from lgmd2jax.alarms._pieces import pieces
from lgmd2jax.fitting import Free
from lgmd2jax.fitting._search.space import Space

# Shortfalls are counted from a margin that no model reaches, U' lying in [.5, 1): the descent always has a slope.
_GOAL = 0.25
_SMOOTH = 0.02  # at temperature 1: within so much of U' frames count alike in a soft maximum


class Event(NamedTuple):
    """A window of a clip, in which an alarm is wanted, or the silence of a piece of it, with what an error weighs.

    `clip`: the clip's number.
    """

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

    def events_of(self, clips: Collection[int]) -> Bool[np.ndarray, " event"]:
        """Which events belong to some of the clips, by their numbers."""
        return np.array([event.clip in clips for event in self.events])

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
    model: LGMD2,
    free: Free,
    clips: Sequence[LabelledClip],
    miss: float,
    false_alarm: float,
    recorded: float | None = None,
) -> AlarmProblem:
    """The problem of labelled clips.

    **Arguments:** `miss`, `false_alarm`: the cost of a missed window, and of false alarms in a piece of a clip.
    `recorded`: what all errors on recorded clips weigh together, as a multiple of all those on rendered ones.
    """
    parts = [(number, piece) for number, clip in enumerate(clips) for piece in pieces(clip)]
    batches, events = batches_of([piece for _, piece in parts]), []
    for batch in batches:
        numbers = [parts[member][0] for member in batch.members]
        for number, has_window in zip(numbers, batch.has_window, strict=True):
            events += [Event(number, True, miss * clips[number].weight)] * sum(has_window)
        for number, has_silence in zip(numbers, batch.has_silence, strict=True):
            events += [Event(number, False, false_alarm * clips[number].weight)] * has_silence
    if recorded is not None:
        events = _balanced(events, {number for number, clip in enumerate(clips) if clip.source is None}, recorded)
    return AlarmProblem(model, Observation(), free, batches, tuple(events), round(float(model.parameters.N_sp)))


def _balanced(events: Sequence[Event], rendered: Collection[int], share: float) -> list[Event]:
    """The events, those of recorded clips together weighing `share` times those of rendered ones, if there are both."""
    of_rendered = sum(event.weight for event in events if event.clip in rendered)
    of_recorded = sum(event.weight for event in events) - of_rendered
    if not (of_rendered and of_recorded):
        return list(events)
    factor = share * of_rendered / of_recorded
    return [event if event.clip in rendered else event._replace(weight=factor * event.weight) for event in events]
