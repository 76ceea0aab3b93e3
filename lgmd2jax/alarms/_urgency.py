"""Urgency: the probability of contact within a time, from what the cell answers."""

import dataclasses
import os
from collections.abc import Mapping, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import scipy
from jaxtyping import Array, Bool, Float, Int, ScalarLike

from lgmd2jax import hard
from lgmd2jax._arguments.checked import checked
from lgmd2jax._handover.model_file import calibrate, calibration_of
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.stages import Response
from lgmd2jax.alarms._clip import ClipLabels, LabelledClip
from lgmd2jax.alarms._reliability import Reliability, calibration_table, logistic_fit

_TAU_MS = 250.0  # over which the potential is averaged: shorter and longer averages predicted no better
_FOLDS = 5  # of clips, each judged by the table of the others
_SETTLE = 10  # frames at the beginning of a clip, in which the network comes to rest


@dataclasses.dataclass(frozen=True)
class Urgency:
    """How likely contact is within `within_ms`, as a logistic function of four numbers between 0 and 1.

    ```python
    urgency = lgmd.alarms.fit_urgency(model, clips, within_ms=500)
    urgency(model, model(frames, fps), interval)   # a probability for each frame
    urgency.save("mine/model.json")                # hard.py then computes it in every step
    ```

    It holds for scenes in which contact is as frequent as in the clips that it was fitted on.

    - `within_ms`: the time asked for. `tau_ms`: over which the level is averaged.
    - `predicted`, `observed`: a calibration table, rising and interpolated: what the logistic function says, and how
      often contact followed; empty for none.
    - `intercept`, and the weights of `smp_adapted`: U' - .5; `level`: the average of recent U, less .5; `rise`: U less
      that average; `inhibition`: Fbar/(Fbar + T), T being T_ffi or A_ffi.
    """

    within_ms: float
    tau_ms: float
    intercept: float
    smp_adapted: float
    level: float
    rise: float
    inhibition: float
    predicted: tuple[float, ...] = ()
    observed: tuple[float, ...] = ()

    @checked
    def __call__(
        self, model: LGMD2, response: Response, interval: Float[Array | np.ndarray, " time"]
    ) -> Float[Array, " time"]:
        """The probability in each frame of a clip. `interval`: ms since the frame before."""
        weights = jnp.array([getattr(self, name) for name in hard.EVIDENCE])
        predicted = jax.nn.sigmoid(self.intercept + _evidence(model, response, interval, self.tau_ms) @ weights)
        if not self.predicted:
            return predicted
        return jnp.interp(predicted, jnp.asarray(self.predicted), jnp.asarray(self.observed))

    @checked
    def reliability(self, model: LGMD2, clips: Sequence[LabelledClip]) -> Reliability:
        """Predicted probability against observed frequency, frame by frame.

        **Raises:** `ValueError` for clips of which none has a frame of contact.
        """
        said, happens, clip = self._predicted(model, clips)
        return Reliability.of(np.interp(said, self.predicted, self.observed) if self.predicted else said, happens, clip)

    @checked
    def recalibrated(self, model: LGMD2, clips: Sequence[LabelledClip]) -> tuple["Urgency", Reliability]:
        """The urgency with a calibration table, from clips that neither the model nor the urgency was fitted on.

        **Returns:** the urgency, and its reliability on the same clips: a fifth of them each is judged by the table of
        the others. Fewer than five clips make no table.

        **Raises:** `ValueError` as `reliability`.
        """
        said, happens, clip = self._predicted(model, clips)
        known = np.unique(clip)
        if len(known) < _FOLDS:
            return dataclasses.replace(self, predicted=(), observed=()), Reliability.of(said, happens, clip)
        fold, probability = np.searchsorted(known, clip) % _FOLDS, np.empty_like(said)
        for number in range(_FOLDS):
            own = fold == number
            probability[own] = np.interp(said[own], *calibration_table(said[~own], happens[~own]))
        predicted, observed = (tuple(column.tolist()) for column in calibration_table(said, happens))
        found = Reliability.of(probability, happens, clip)
        return dataclasses.replace(self, predicted=predicted, observed=observed), found

    def _predicted(
        self, model: LGMD2, clips: Sequence[LabelledClip]
    ) -> tuple[Float[np.ndarray, " frame"], Bool[np.ndarray, " frame"], Int[np.ndarray, " frame"]]:
        """The probability by the logistic function, whether contact followed, and the number of the clip."""
        evidence, happens, clip = _judged(model, clips, self.within_ms, self.tau_ms)
        weights = np.array([getattr(self, name) for name in hard.EVIDENCE])
        return scipy.special.expit(self.intercept + evidence @ weights), happens, clip

    @checked
    def save(self, path: str | os.PathLike) -> None:
        """Add it to a hand-over file, in the place of one that is there."""
        calibrate(path, "urgency", {name: value for name, value in dataclasses.asdict(self).items() if value != ()})


@checked
def load_urgency(path: str | os.PathLike) -> Urgency | None:
    """The urgency of a hand-over file; None where it has none.

    **Raises:** as `lgmd2jax.load`.
    """
    table: Mapping[str, Any] | None = calibration_of(path).get("urgency")
    if table is None:
        return None
    values: dict[str, Any] = {name: tuple(table.get(name, ())) for name in hard.CALIBRATION}
    return Urgency(**{**table, **values})


@checked
def fit_urgency(
    model: LGMD2, clips: Sequence[LabelledClip], within_ms: float | int = 500.0, tau_ms: float | int = _TAU_MS
) -> Urgency:
    """Calibrate the urgency on labelled clips, by logistic regression over their frames.

    A frame counts as one before contact where its clip's `contact` follows within the time asked for. Frames from
    contact on are left out, and so are clips with an alarm window without a frame of contact.

    **Raises:** `ValueError` for times that are not positive, and for clips in which contact never or always follows.
    """
    for name, value in (("within_ms", within_ms), ("tau_ms", tau_ms)):
        if not (np.isfinite(value) and value > 0):
            raise ValueError(f"{name} is {value!r}; give a positive number of ms")
    evidence, happens, _ = _judged(model, clips, float(within_ms), float(tau_ms))
    if happens.all() or not happens.any():
        raise ValueError(
            f"contact follows within {within_ms:g} ms in {'all' if happens.all() else 'none'} of the frames; "
            "give clips with contact and clips without"
        )
    intercept, smp_adapted, level, rise, inhibition = logistic_fit(evidence, happens)
    return Urgency(float(within_ms), float(tau_ms), intercept, smp_adapted, level, rise, inhibition)


def _judged(
    model: LGMD2, clips: Sequence[LabelledClip], within_ms: float, tau_ms: float
) -> tuple[Float[np.ndarray, "frame 4"], Bool[np.ndarray, " frame"], Int[np.ndarray, " frame"]]:
    """Of all frames that can be judged: the evidence, whether contact follows in time, and the number of the clip."""
    parts = []
    for number, clip in enumerate(clips):
        if clip.windows and clip.contact is None:
            continue
        left = _time_left(clip)
        judged = (np.arange(len(left)) >= _SETTLE) & (left > 0)
        response = model(clip.frames, interval=clip.interval)
        evidence = np.asarray(_evidence(model, response, clip.interval, tau_ms))[judged]
        parts.append((evidence, left[judged] <= within_ms, np.full(judged.sum(), number)))
    if not parts or not sum(len(happens) for _, happens, _ in parts):
        raise ValueError("no clip has a frame of contact; label it: contact = FRAME")
    evidence, happens, numbers = map(np.concatenate, zip(*parts, strict=True))
    return evidence, happens, numbers


def _time_left(clip: ClipLabels) -> Float[np.ndarray, " time"]:
    """Until contact, in ms; infinite where there is none."""
    contact = clip.contact_ms
    return np.full(len(clip.time), np.inf) if contact is None else contact - clip.time


@jax.jit
def _evidence(
    model: LGMD2, response: Response, interval: Float[Array | np.ndarray, " time"], tau_ms: ScalarLike
) -> Float[Array, "time 4"]:
    """The numbers that `hard.EVIDENCE` names."""

    def average(level, moment):
        u, lasts = moment
        level = level - jnp.expm1(-lasts / tau_ms) * (u - level)
        return level, level

    u, ffi = response.smp, response.ffi
    _, level = jax.lax.scan(average, jnp.full((), 0.5, u.dtype), (u, jnp.asarray(interval, u.dtype)))
    inhibition = ffi / (ffi + model.cell.inhibited_from)
    return jnp.stack([response.smp_adapted - 0.5, level - 0.5, u - level, inhibition], axis=1)
