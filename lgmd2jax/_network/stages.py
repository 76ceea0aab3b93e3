"""The two stages of a network: pixels, which leave two sums of a frame, and the cell, which sees only these."""

import abc
from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
from jaxtyping import Array, Float, Real

from lgmd2jax._types import Map, Scalar

Record = Callable[[Any], Any]  # from the layers of a frame to what is kept of them
Interval = Float[Array, " *time"]  # ms that a frame lasts: one for all, or one for each


class Sums(NamedTuple):
    """What the pixels leave of a frame, or of each frame of a clip: MP (eq. 11) and F (eq. 13), in grey levels.

    With size-coding inhibition F is a share of the field.
    """

    mp: Float[Array, " *time"]
    f: Float[Array, " *time"]


class Response(eqx.Module):
    """What the cell does, a value a frame (scalars from `LGMD2.step`).

    - `mp`: summed potential MP, in grey levels (eq. 11).
    - `ffi`: delayed feed-forward inhibition Fbar, in grey levels (eq. 14), those of a thirtieth of a second where the
      cell sees change per time; with size-coding inhibition a share of the field. `channels` of a network says which.
    - `smp`: sigmoid membrane potential U, in [.5, 1), before adaptation (eq. 12).
    - `smp_adapted`: U' after spike-frequency adaptation (eq. 15).
    - `spikes`: spikes in this frame, 0 to 2 (eq. 16); fractional between thresholds that are soft.
    - `collision`: the alarm, 0 or 1 (eq. 17); fractional likewise.
    - `recorded`: what the `record` function returned, with time as the first axis; None without one.
    """

    mp: Float[Array, " *time"]
    ffi: Float[Array, " *time"]
    smp: Float[Array, " *time"]
    smp_adapted: Float[Array, " *time"]
    spikes: Float[Array, " *time"]
    collision: Float[Array, " *time"]
    recorded: Any = None


class Levels(NamedTuple):
    """Where a curve crosses what: the SMP from which there are one, two.. spikes, the FFI that inhibits the cell.

    `inhibited_from`: the parameter by which that FFI is known.
    """

    spikes: tuple[float, ...]
    ffi: float
    inhibited_from: str = "T_ffi"

    @property
    def by_count(self) -> dict[str, float]:
        """The SMP from which there is `1 spike`, from which there are `2 spikes`, and so on."""
        return {f"{count} spike{'s' * (count > 1)}": level for count, level in enumerate(self.spikes, start=1)}


class AbstractPixels(eqx.Module):
    """The pixel stage of a network: from frames to `Sums`.

    A subclass defines `rest` and `step`. `over` runs these frame by frame, and JAX differentiates it; a stage that
    knows a cheaper way to the same numbers defines an `over` of its own.
    """

    parameters: eqx.AbstractVar[Any]  # a ParameterSet

    @abc.abstractmethod
    def rest(self, frame: Map) -> Any:
        """The state of pixels that saw `frame` and no change."""

    @abc.abstractmethod
    def step(self, state: Any, frame: Map, interval: Scalar) -> tuple[Any, Sums, Any]:
        """The next state, the sums of this frame, and its layers for `record`.

        **Arguments:** `interval` in ms since the frame before.
        """

    def over(
        self, frames: Real[Array, "time row col"], interval: Interval, record: Record | None = None
    ) -> tuple[Sums, Any]:
        """The sums over a clip, and what was recorded.

        **Arguments:** `frames` of integers too; `interval` in ms, one or one a frame, in the dtype of the parameters.
        """
        return self.plain(frames, interval, record)

    def plain(
        self, frames: Real[Array, "time row col"], interval: Interval, record: Record | None = None
    ) -> tuple[Sums, Any]:
        """The same as `over`, by `step`, frame by frame, with JAX's own derivatives."""

        def step(state, moment):
            frame, own = moment
            state, sums, layers = self.step(state, frame.astype(interval.dtype), interval if own is None else own)
            return state, (sums, None if record is None else record(layers))

        own = interval if interval.ndim else None
        return jax.lax.scan(step, self.rest(frames[0].astype(interval.dtype)), (frames, own))[1]


class AbstractCell(eqx.Module):
    """The cell of a network: from `Sums` to `Response`. A subclass defines `rest` and `step`."""

    parameters: eqx.AbstractVar[Any]  # a ParameterSet

    @abc.abstractmethod
    def rest(self) -> Any:
        """The state before the first frame, in the dtype of the parameters."""

    @abc.abstractmethod
    def step(self, state: Any, sums: Sums, interval: Scalar, pixels: int) -> tuple[Any, Response]:
        """The next state and the response of this frame.

        **Arguments:** `sums`: of this frame. `interval`: ms since the frame before. `pixels`: how many a frame has, n
        of eq. 12. All numbers come in one dtype.
        """

    def over(self, sums: Sums, interval: Interval, pixels: int) -> Response:
        """The response to a clip, from rest."""

        def step(state, moment):
            now, own = moment
            return self.step(state, now, interval if own is None else own, pixels)

        own = interval if interval.ndim else None
        return jax.lax.scan(step, self.rest(), (sums, own))[1]
