"""What networks have in common: the response to a clip, and a frame at a time."""

import abc
import dataclasses
import functools
import math
import typing
from collections.abc import Mapping
from typing import Any, Literal, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Real

from lgmd2jax._arguments.checked import checked_names
from lgmd2jax._channels import RESPONSE, Description
from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._eye import Eye
from lgmd2jax._network.given import as_pixels, check_record, positive, warn_of_levels
from lgmd2jax._network.parameter_set import ParameterSet, check_domains, declared
from lgmd2jax._network.stages import AbstractCell, AbstractPixels, Interval, Levels, Record, Response, Sums
from lgmd2jax._network.structure import structure_fields
from lgmd2jax._network.thresholds import Thresholds
from lgmd2jax._types import Number, cast, is_concrete, unless_nan
from lgmd2jax._words import warn
from lgmd2jax.hard import SECONDS

Neuron = Literal["LGMD2", "LGMD1"]


class State(eqx.Module):
    """All that a network keeps from one frame to the next. `shape`: (row, col) of its frames."""

    pixels: Any
    cell: Any
    shape: tuple[int, int] = eqx.field(static=True)


class AbstractNetwork(eqx.Module):
    """A network in two stages: pixels, of which two sums a frame are left, and the cell, which sees only these.

    One definition of each stage serves a clip, a stream, and fits, which keep the sums while only the cell changes.
    `LGMD2` and `YueRindLGMD1` are two. One of your own is a subclass with these fields and properties:

    - `parameters`: of a `ParameterSet` of its own, whose fields declare unit, domain, bounds, stage and what becomes of
      them at another frame rate and in another field of view.
    - `thresholds`: `Hard()`, `Soft(temperature)` or `StraightThrough(temperature)`.
    - `eye`: the sampling that the parameters belong to, or None.
    - `pixels`, `cell`: the stages, an `AbstractPixels` and an `AbstractCell`, made from the fields.
    - `ablations`: by name, the values of parameters or of other fields that take a mechanism out.
    - `unused`: the parameters that act on nothing in this structure; a fit refuses to free them.
    - `levels`: the thresholds of the cell, which figures draw; `channels`: the unit and meaning of each channel of the
      response, where they are others than of the LGMD2.
    - `neuron`: as which neuron the 22 properties judge it; any LGMD unless it says otherwise.
    - `conflicts`: what is wrong with parameters that are right each by itself.

    Fields that are structure, such as a number of frames, are made by `counts` or `one_of`.

    **Raises:** `ValueError` for fields of another kind, and for structure that does not exist.
    """

    parameters: eqx.AbstractVar[Any]  # a ParameterSet
    thresholds: eqx.AbstractVar[Thresholds]
    eye: eqx.AbstractVar[Eye | None]

    @property
    @abc.abstractmethod
    def pixels(self) -> AbstractPixels:
        """The stage from frames to sums."""

    @property
    @abc.abstractmethod
    def cell(self) -> AbstractCell:
        """The stage from sums to response."""

    @property
    def ablations(self) -> Mapping[str, Mapping[str, Any]]:
        """By name, the values of parameters or of other fields that take a mechanism out."""
        return {}

    @property
    def unused(self) -> frozenset[str]:
        """The parameters that act on nothing in this structure."""
        return frozenset()

    @property
    def levels(self) -> Levels:
        """The thresholds of the cell, as figures draw them; none here."""
        return Levels((), math.inf)

    @property
    def channels(self) -> Mapping[str, Description]:
        """What each channel of the response is, with its unit."""
        return RESPONSE

    @property
    def neuron(self) -> Neuron:
        """As which neuron the 22 properties judge the network: one that answers dark approach alone, or any LGMD."""
        return "LGMD1"

    def conflicts(self) -> dict[str, Bool[Array, "*batch"]]:
        """For each sentence of what parameters must not do together, whether they do."""
        return {}

    def at_interval(self, ratio: float):
        """The network for frames that last `ratio` times as long: by what parameters and structure declare."""
        changes = {
            name: symbol.at_interval(getattr(self.parameters, name), ratio)
            for name, symbol in declared(type(self.parameters)).items()
            if symbol.per_frame != "as it is"
        }
        structure = {
            name: field.at_interval(getattr(self, name), ratio) for name, field in structure_fields(type(self)).items()
        }
        return dataclasses.replace(self, parameters=dataclasses.replace(self.parameters, **changes), **structure)

    def in_field(self, ratio: float):
        """The network for a field of view of `ratio` times the area: by what parameters declare."""
        changes = {
            name: symbol.in_field(getattr(self.parameters, name), ratio)
            for name, symbol in declared(type(self.parameters)).items()
        }
        return dataclasses.replace(self, parameters=dataclasses.replace(self.parameters, **changes))

    def __hash__(self):
        """By value, as equality is, so that `jax.jit(model)` compiles once for equal models."""
        return hash((type(self), *(np.asarray(leaf).tobytes() for leaf in jax.tree.leaves(self))))

    def __check_init__(self):
        kinds = {"parameters": (parameters_of(type(self)),), "thresholds": (Thresholds,), "eye": (Eye, type(None))}
        for name, kind in kinds.items():
            if not isinstance(getattr(self, name), kind):
                wanted = " or ".join("None" if each is type(None) else each.__name__ for each in kind)
                raise ValueError(f"{name} is {getattr(self, name)!r}; give {wanted}")
        for name, structure in structure_fields(type(self)).items():
            structure.check(name, getattr(self, name))
        self._check_conflicts()

    def __repr__(self):
        thresholds = f"{type(self.thresholds).__name__}({getattr(self.thresholds, 'temperature', '')})"
        others = [field.name for field in dataclasses.fields(self) if field.name not in ("parameters", "thresholds")]
        fields = ", ".join([thresholds, *(f"{name}={getattr(self, name)!r}" for name in others)])
        return f"{type(self).__name__}({fields},\n{self.parameters})"

    @checked_names
    def __call__(
        self,
        frames: Real[Array | np.ndarray, "time row col"],
        fps: Number | None = None,
        *,
        interval: Real[Array | np.ndarray, " time"] | None = None,
        record: Record | None = None,
        check: bool = False,
    ) -> Response:
        """The response to a clip.

        **Arguments:**

        - `frames`: grey levels 0..255, at least 2 frames of at least 3 x 3 pixels. Pixels compute in this dtype, the
          cell in the promotion of it with the parameters'. Integers, such as a camera's uint8, are read as they are,
          which is fastest; pixels then compute in the dtype of the parameters.
        - `fps`: frames per second, by default the eye's.
        - `interval`: ms since the frame before, for each frame, instead of `fps`, where the clock is uneven.
        - `record`: a function of the network's layers (`Layers` or `YueRindLayers`) that returns what to keep of every
          frame. A function is compiled once, so define it outside of a loop.
        - `check`: test the values inside a traced call too, at about twice the cost.

        **Raises:** `ValueError` for a wrong shape, and for concrete values that are not finite or out of their domain.
        """
        frames = as_pixels(frames, "frames", "(time, row, col)", rank=3)
        if len(frames) < 2:
            count = "one frame" if len(frames) else "0 frames"
            raise ValueError(f"frames holds {count}; the network sees changes, so give at least 2")
        if is_concrete(frames):
            warn_of_levels(np.asarray(frames))
        check_record(record)
        lasts = self._interval(fps, interval, (len(frames),))
        check_domains(self.parameters)
        self._check_conflicts()
        response = _respond(self, frames, lasts, record)
        return self._checked(response, lasts, check)

    @checked_names
    def init(self, frame: Real[Array | np.ndarray, "row col"]) -> State:
        """The state before the first frame: at rest, with `frame` as what was seen before, L(-1).

        `step(init(frames[0]), frames[0], fps)` is the first output of a clip.

        **Raises:** `ValueError` for a wrong shape.
        """
        frame = as_pixels(frame, "frame", "(row, col)", rank=2)
        if is_concrete(frame):
            warn_of_levels(np.asarray(frame))
        rows, cols = frame.shape
        frame = frame.astype(self._dtype_for(frame))
        return State(_in(self.pixels, frame.dtype).rest(frame), self._cell_for(frame).rest(), (rows, cols))

    @checked_names
    def step(
        self,
        state: State,
        frame: Real[Array | np.ndarray, "row col"],
        fps: Number | None = None,
        *,
        interval: Number | None = None,
        record: Record | None = None,
        check: bool = False,
    ) -> tuple[State, Response]:
        """One frame: the next state, and the response now.

        **Arguments:** as for a call, with one `frame` of (row, col), and

        - `interval`: ms since the last frame, instead of `fps`, for a camera whose clock jitters or that loses frames.
          The time constants are then right; the change of luminance still is the one between the two frames.

        A buffer of NumPy's may be refilled for each frame. In a `jax.jit` of your own it may not, since JAX reads it
        later, perhaps after that: give `jnp.array(buffer)`, a copy.

        **Raises:** `ValueError` as for a call, and for a frame of another size than the state's.
        """
        frame = as_pixels(frame, "frame", "(row, col)", rank=2)
        if not isinstance(state, State):
            raise ValueError(f"state is {state!r:.40}; give the one that init or the last step returned")
        if frame.shape != state.shape:
            raise ValueError(f"frame has shape {frame.shape}, the state {state.shape}; start again with init(frame)")
        check_record(record)
        lasts = self._interval(fps, interval, ())
        state, response = _advance(self, state, frame, lasts, record)
        return state, self._checked(response, lasts, check)

    def sums(
        self, frames: Real[Array, "time row col"], interval: Interval, record: Record | None = None
    ) -> tuple[Sums, Any]:
        """The pixel stage over a clip: MP(t), F(t) and what was recorded.

        **Arguments:** `interval` in ms, one or one a frame.
        """
        dtype = self._dtype_for(frames)
        return _in(self.pixels, dtype).over(frames, interval.astype(dtype), record)

    def respond(self, sums: Sums, interval: Interval, pixels: int) -> Response:
        """The cell over a clip, from MP(t) and F(t).

        **Arguments:** `interval` in ms, one or one a frame; `pixels` of a frame.
        """
        cell = self._cell_for(sums.mp)
        return _nan_as(sums, cell.over(*cast((sums, interval), cell.parameters.dtype), pixels))

    def _dtype_for(self, frames: Array) -> jnp.dtype:
        """In which pixels compute: that of the frames, for integers that of the parameters."""
        return frames.dtype if jnp.issubdtype(frames.dtype, jnp.floating) else self.parameters.dtype

    def _cell_for(self, pixels: Array) -> AbstractCell:
        """The cell in its own precision."""
        return _in(self.cell, jnp.result_type(pixels.dtype, self.parameters.dtype))

    def _interval(self, fps, interval, shape: tuple[int, ...]) -> Array:
        if interval is not None:
            if fps is not None:
                raise ValueError("fps and interval are both given; give the one that is known")
            interval = positive(interval, "interval", "ms", shape)
            if is_concrete(interval) and SECONDS[0] < (usual := float(np.median(interval))) < SECONDS[1]:
                warn(f"interval is {usual:.4g} ms; was {1000 * usual:.4g} ms meant, given in s?")
            return interval
        if fps is None:
            if self.eye is None:
                raise ValueError("fps is missing; give it, or a model with an eye")
            fps = self.eye.fps
        interval = 1000 / positive(fps, "fps", "frames per second", ())
        if is_concrete(fps) and fps < 1:
            warn(f"fps is {fps:.4g}; were {1 / fps:.4g} meant, given as an interval in s?")
        if self.eye is not None and is_concrete(fps) and abs(fps / self.eye.fps - 1) > 0.01:
            warn(f"the parameters belong to {self.eye.fps:g} frames per second, not {fps:g}")
        return interval

    def _check_conflicts(self) -> None:
        with jax.ensure_compile_time_eval():
            for sentence, present in self.conflicts().items():
                if is_concrete(present) and np.any(present):
                    raise ValueError(sentence)

    def _checked(self, response: Response, interval, check: bool) -> Response:
        """The response, once it is clear that frames and parameters were in order.

        A frame that is not finite shows in F, the mean over all pixels, so that no second pass over frames is needed.
        """
        if is_concrete(response.ffi):
            bad = np.flatnonzero(~np.isfinite(response.ffi))
            if bad.size:
                raise ValueError(f"frames holds values that are not finite, first in frame {bad[0]}; mask or fill them")
        elif check:
            response = eqx.error_if(response, ~jnp.isfinite(response.ffi), "frames holds values that are not finite")
            lasts = (interval > 0) & jnp.isfinite(interval)
            response = eqx.error_if(response, ~lasts, "fps is not positive")
            for name, symbol in declared(type(self.parameters)).items():
                outside = ~symbol.contains(getattr(self.parameters, name))
                response = eqx.error_if(response, outside, f"{name} must lie in {symbol.domain}")
            for sentence, present in self.conflicts().items():
                response = eqx.error_if(response, present, sentence)
        return response


AnyNetwork = TypeVar("AnyNetwork", bound=AbstractNetwork)
Stage = TypeVar("Stage", bound=AbstractPixels | AbstractCell)


@functools.cache
def parameters_of(kind: type[AbstractNetwork]) -> type[ParameterSet]:
    """The class of a network's parameters, as its field `parameters` is annotated."""
    return typing.get_type_hints(kind)["parameters"]


@traced_once
def _respond(network: AbstractNetwork, frames, interval, record) -> Response:
    network, interval = _opaque((network, interval))
    sums, recorded = network.sums(frames, interval, record)
    return dataclasses.replace(network.respond(sums, interval, frames[0].size), recorded=recorded)


@traced_once
def _advance(network: AbstractNetwork, state: State, frame, interval, record) -> tuple[State, Response]:
    network, interval = _opaque((network, interval))
    frame = frame.astype(network._dtype_for(frame))
    pixels, cell = _in(network.pixels, frame.dtype), network._cell_for(frame)
    rest = jax.eval_shape(lambda: (pixels.rest(frame), cell.rest()))
    if _form(rest) != _form((state.pixels, state.cell)):
        raise ValueError("state belongs to a model of another structure; start again with init(frame)")
    pixel_state, sums, layers = pixels.step(state.pixels, frame, interval.astype(frame.dtype))
    cell_state, response = cell.step(state.cell, *cast((sums, interval), cell.parameters.dtype), frame.size)
    response = dataclasses.replace(_nan_as(sums, response), recorded=None if record is None else record(layers))
    return State(pixel_state, cell_state, state.shape), response


def _form(tree) -> tuple[Any, list[tuple[int, ...]]]:
    return jax.tree.structure(tree), [leaf.shape for leaf in jax.tree.leaves(tree)]


def _nan_as(sums: Sums, response: Response) -> Response:
    """The response, NaN where F is: a cell that acts late, or compares, would hide for a while that a frame was NaN."""
    return jax.tree.map(lambda channel: unless_nan(sums.f, channel), response)


def _in(stage: Stage, dtype) -> Stage:
    """The stage with its parameters in this dtype."""
    return eqx.tree_at(lambda stage: stage.parameters, stage, cast(stage.parameters, dtype))


def _opaque(tree):
    """The same, but never folded as a constant: so closed-over and passed parameters round alike, to the bit.

    One barrier a leaf: a common one would spread a tangent of one leaf over all of them.
    """
    arrays, rest = eqx.partition(tree, eqx.is_array)
    return eqx.combine(jax.tree.map(jax.lax.optimization_barrier, arrays), rest)
