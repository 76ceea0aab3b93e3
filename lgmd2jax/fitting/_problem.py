"""What a fit minimises: the differences between curves and targets, as a function of a point in the unit box."""

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.tree_util import Partial
from jaxtyping import Array, Bool, Float

from lgmd2jax._compute.batching import each
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.stages import Sums
from lgmd2jax._targets.observation import Observation
from lgmd2jax._targets.target import Target, stride
from lgmd2jax._types import strong
from lgmd2jax.fitting._free import Free
from lgmd2jax.fitting._poisson import LEAST_RATE, bin_means, deviance_residuals, minus_two_log_likelihood
from lgmd2jax.fitting._robust import Loss, robust
from lgmd2jax.fitting._search.space import Space
from lgmd2jax.stimuli import Stimulus

# Far beyond any kernel: no smoothing reaches from a frame that a clip has into one that only fills up its batch.
_FAR_MS = 1e6

# Of every batch, each of its own size: the curve of each slot; (condition, time).
Curves = list[list[Float[Array, "_ _"]]]


class Slot(eqx.Module):
    """One target of each condition of a batch; `scale` is 0 where there is none.

    `low` and `high` are the edges of a band, both of them the values of a curve. `thinning` is how many frames, each as
    close to its neighbours as this one, make one independent sample. `exposure` is 0 but for counts of spikes: the time
    in which they were counted, in s, by weight.
    """

    channel: str = eqx.field(static=True)
    is_counts: bool = eqx.field(static=True)
    low: Float[Array, "condition time"]
    high: Float[Array, "condition time"]
    scale: Float[Array, "condition time"]
    thinning: Float[Array, "condition time"]
    exposure: Float[Array, "condition time"]

    def inside(self, curve: Float[Array, "condition time"]) -> Bool[Array, "condition time"]:
        """Where a curve lies within a band, edges included."""
        return (self.low < self.high) & (self.low <= curve) & (curve <= self.high)

    def nearest(self, curve: Float[Array, "condition time"]) -> Float[Array, "condition time"]:
        """What of the target lies nearest to a curve: within a band the curve itself, so that no slope is left."""
        return jnp.where(self.inside(curve), curve, jnp.where(curve > self.low, self.high, self.low))

    def means(self, curve: Float[Array, "condition time"]) -> Float[Array, "condition time"]:
        """The counts that a rate lets expect; 1 where nothing was counted."""
        counted = self.exposure > 0
        rates = jnp.maximum(jax.vmap(bin_means)(curve, counted), LEAST_RATE)
        return jnp.where(counted, rates * self.exposure, 1.0)

    def difference(self, curve: Float[Array, "condition time"]) -> Float[Array, "condition time"]:
        """Of a curve from the target, in standard errors; of counts the deviance residual. 0 without a target."""
        if self.is_counts:
            counted = self.exposure > 0
            return jnp.where(counted, deviance_residuals(self.low * self.exposure, self.means(curve)), 0.0)
        return self.scale * (curve - self.nearest(curve))


class Place(NamedTuple):
    """Where the target of a condition stands."""

    batch: int
    slot: int
    row: int


class Batch(eqx.Module):
    """Conditions of one raster, held at their last frame up to a common length."""

    frames: Float[Array, "condition time row col"]
    interval: Float[Array, " condition"]
    time: Float[Array, "condition time"]
    slots: tuple[Slot, ...]


class Problem(Space[AbstractNetwork]):
    """A fit's data and what is free. Two problems of the same shapes share what is compiled, whatever their bounds."""

    batches: tuple[Batch, ...]
    places: tuple[tuple[Place, ...], ...] = eqx.field(static=True)
    loss: Loss = eqx.field(static=True, default="squares")

    def sums(self, model: AbstractNetwork) -> tuple[Sums, ...]:
        """MP and F of every batch, (condition, time): all that the cell needs."""

        def one(batch: Batch):
            return each(lambda clip: model.sums(*clip)[0], (batch.frames, batch.interval))

        return tuple(one(batch) for batch in self.batches)

    def curves(self, model: AbstractNetwork, observation: Observation, sums: tuple[Sums, ...]) -> Curves:
        """The predicted curve of every slot of every batch."""
        curves = []
        for batch, batch_sums in zip(self.batches, sums, strict=True):
            pixels, channels = batch.frames[0, 0].size, [slot.channel for slot in batch.slots]

            def one(sums, interval, time, pixels=pixels, channels=channels):
                response = model.respond(sums, interval, pixels)
                rate = observation(response.smp_adapted, time) if "rate" in channels else None
                return [rate if channel == "rate" else getattr(response, channel) for channel in channels]

            curves.append(jax.vmap(one)(batch_sums, batch.interval, batch.time))
        return curves

    def differences(self, curves: Curves) -> Float[Array, " n"]:
        """(curve - target) in standard errors, robust if so wished; 0 where there is no target, and within a band.

        Where so many frames make one sample, the square of each counts as that fraction of one.
        """
        rows = [
            (robust(slot.difference(curve), self.loss) / jnp.sqrt(slot.thinning)).ravel()
            for batch, predicted in zip(self.batches, curves, strict=True)
            for slot, curve in zip(batch.slots, predicted, strict=True)
        ]
        return jnp.concatenate(rows)

    def residuals(
        self, z: Float[Array | np.ndarray, " free"], temperature: Float[Array, ""] | None
    ) -> Float[Array, " n"]:
        """All differences, then the penalties of the priors."""
        return self.evaluated(z, temperature)[0]

    def evaluated(
        self, z: Float[Array | np.ndarray, " free"], temperature: Float[Array, ""] | None
    ) -> tuple[Float[Array, " n_and_priors"], Curves]:
        """The residuals, and the curves that they come from."""
        model, observation = self.at(z, temperature)
        curves = self.curves(model, observation, self.sums(model))
        return jnp.concatenate([self.differences(curves), self.free.penalties(z)]), curves

    @property
    def scale(self) -> float:
        """The norm of the factors of all differences."""
        slots = [slot for batch in self.batches for slot in batch.slots]
        rows = [np.asarray(slot.scale) / np.sqrt(slot.thinning) for slot in slots]
        return float(np.linalg.norm(np.concatenate([row.ravel() for row in rows])))

    @property
    def priors(self) -> int:
        """How many of the residuals, at their end, are penalties."""
        return sum(parameter.has_prior for parameter in self.free.structure)

    def known(self) -> Bool[np.ndarray, " n_and_priors"]:
        """Which of the residuals count: differences with a target, and penalties."""
        rows = [np.ravel(slot.scale) > 0 for batch in self.batches for slot in batch.slots]
        return np.concatenate([*rows, np.ones(self.priors, bool)])

    def frame_errors(self, variance: float) -> dict[str, float]:
        """By channel, the standard error that one frame would have if its neighbours told nothing of it.

        A frame holds a fraction of a sample only, and its error counts as larger, where frames are correlated and where
        values are further apart than the frames.

        **Arguments:** `variance`: of a residual.
        """
        scales: dict[str, list[np.ndarray]] = {}
        for batch in self.batches:
            for slot in batch.slots:
                for scale, thinning in zip(np.asarray(slot.scale), np.asarray(slot.thinning), strict=True):
                    each = scale / np.sqrt(thinning * stride(scale))
                    scales.setdefault(slot.channel, []).append(each[scale > 0])
        noise = max(float(np.sqrt(variance)), 1e-9)  # a twin without noise has none
        return {channel: noise / float(np.median(np.concatenate(rows))) for channel, rows in scales.items()}

    def samples(self) -> float:
        """How many independent samples the targets hold."""
        slots = (jax.tree.map(np.asarray, slot) for batch in self.batches for slot in batch.slots)
        return sum(float(((slot.scale > 0) / slot.thinning).sum()) for slot in slots)

    @property
    def has_counts(self) -> bool:
        """Whether a target is counts of spikes."""
        return any(slot.is_counts for batch in self.batches for slot in batch.slots)

    def minus_two_log_likelihood(self, curves: Curves) -> float | None:
        """-2 ln L, up to a constant of the targets with known errors; None where no target is a count of spikes."""
        if not self.has_counts:
            return None
        total = 0.0
        for batch, predicted in zip(self.batches, curves, strict=True):
            for slot, curve in zip(batch.slots, predicted, strict=True):
                if slot.is_counts:
                    counted = np.asarray(slot.exposure) > 0
                    counts, means = np.asarray(slot.low * slot.exposure), np.asarray(slot.means(curve))
                    total += minus_two_log_likelihood(counts[counted], means[counted])
                else:
                    total += float(jnp.square(slot.difference(curve) / jnp.sqrt(slot.thinning)).sum())
        return total

    def samples_inside(self, curves: Curves) -> float | None:
        """How many of them lie within a band; None where no target is one."""
        rows = [
            ((slot.scale > 0) & slot.inside(curve)) / slot.thinning
            for batch, predicted in zip(self.batches, curves, strict=True)
            for slot, curve in zip(batch.slots, predicted, strict=True)
            if np.any(np.asarray(slot.low) < np.asarray(slot.high))
        ]
        return sum(float(row.sum()) for row in rows) if rows else None


def chi2_residuals(problem: Problem, temperature: float, variance: float) -> Partial:
    """The residuals of a point whose sum of squares, divided by `variance`, is chi2: penalties keep their width.

    All that they depend on is an argument, so that another parameter's profile compiles nothing.
    """
    return Partial(_chi2_residuals, problem, strong(temperature), strong(variance))


def _chi2_residuals(
    problem: Problem, temperature: Float[Array, ""], variance: Float[Array, ""], z: Float[Array, " free"]
) -> Float[Array, " n_and_priors"]:
    residuals = problem.residuals(z, temperature)
    data = len(residuals) - problem.priors
    return residuals.at[data:].multiply(jnp.sqrt(variance))


def problem_of(
    model: AbstractNetwork,
    observation: Observation,
    free: Free,
    conditions: Sequence[tuple[Stimulus, Sequence[Target]]],
    loss: Loss,
) -> Problem:
    """The problem of fitting a model to conditions, the ones of a raster in one batch."""
    rasters: dict[tuple, list[int]] = {}
    for number, (stimulus, _) in enumerate(conditions):
        rasters.setdefault((*stimulus.frames.shape[1:], stimulus.frames.dtype), []).append(number)
    places: list[tuple[Place, ...]] = [()] * len(conditions)
    batches = []
    for number, members in enumerate(rasters.values()):
        batch, slots = _batch([conditions[member] for member in members])
        batches.append(batch)
        for row, member in enumerate(members):
            places[member] = tuple(Place(number, slot, row) for slot in slots[row])
    return Problem(model, observation, free, tuple(batches), tuple(places), loss)


def _batch(members: Sequence[tuple[Stimulus, Sequence[Target]]]) -> tuple[Batch, list[list[int]]]:
    """The batch, and for each of its conditions the slots of its targets."""
    length = max(len(stimulus.frames) for stimulus, _ in members)

    def padded(rows, **settings):
        rows = [np.asarray(row) for row in rows]
        rows = [np.pad(row, [(0, length - len(row))] + [(0, 0)] * (row.ndim - 1), **settings) for row in rows]
        return jax.device_put(np.stack(rows))

    # By channel, whether they are counts, and which of a condition's targets of that kind it is.
    columns: dict[tuple[str, bool, int], list[Target | None]] = {}
    columns_of: list[list[tuple[str, bool, int]]] = []
    for row, (_, targets) in enumerate(members):
        counts: Counter[tuple[str, bool]] = Counter()
        columns_of.append([])
        for target in targets:
            kind = target.channel, target.exposure is not None
            column = (*kind, counts[kind])
            counts[kind] += 1
            columns_of[row].append(column)
            columns.setdefault(column, [None] * len(members))[row] = target

    def rows(column, values_of, fill=0.0):
        targets = zip(column, members, strict=True)
        rows = [
            np.full(len(each.frames), fill) if target is None else values_of(target) for target, (each, _) in targets
        ]
        return padded(rows, constant_values=fill)

    slots = [
        Slot(
            channel,
            is_counts,
            rows(column, lambda target: target.values),
            rows(column, lambda target: target.values if target.upper is None else target.upper),
            rows(column, lambda target: target.scale),
            rows(column, lambda target: target.thinning, fill=1.0),
            rows(
                column,
                lambda target: (
                    np.zeros(len(target.values)) if target.exposure is None else target.exposure * target.weight
                ),
            ),
        )
        for (channel, is_counts, _), column in columns.items()
    ]
    far = _FAR_MS * np.arange(1, length + 1)
    times = [np.asarray(stimulus.time) for stimulus, _ in members]
    batch = Batch(
        frames=padded([stimulus.frames for stimulus, _ in members], mode="edge"),
        interval=jax.device_put(np.array([1000 / stimulus.fps for stimulus, _ in members])),
        time=jax.device_put(np.stack([np.concatenate([time, time[-1] + far[: length - len(time)]]) for time in times])),
        slots=tuple(slots),
    )
    order = list(columns)
    return batch, [[order.index(column) for column in row] for row in columns_of]
