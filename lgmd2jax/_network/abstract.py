"""What networks have in common: a clip, a frame at a time, and the checks at the border to their users."""

import abc
import dataclasses
import warnings
from collections.abc import Callable
from typing import Any, ClassVar, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Real

from lgmd2jax._eye import Eye
from lgmd2jax._network import retina
from lgmd2jax._network.parameters import check_domains, declared
from lgmd2jax._network.thresholds import Thresholds
from lgmd2jax._types import Map, Number, Scalar, cast, is_concrete


class State(eqx.Module):
    """All that a network keeps from one frame to the next."""

    pixels: Any
    cell: Any


class Response(eqx.Module):
    """What the cell does, a value a frame (scalars from `LGMD2.step`).

    - `mp`: summed potential MP, in grey levels (eq. 11).
    - `ffi`: delayed feed-forward inhibition Fbar, in grey levels (eq. 14).
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


Record = Callable[[Any], Any]  # from the layers of a frame to what is kept of them


class Network(eqx.Module):
    """A network in two stages: pixels, of which two numbers a frame are left, and the cell, which sees only these.

    One definition of each stage serves a clip, a stream, and fits, which keep the pixels' numbers while only the cell
    changes. `LGMD2` and `YueRindLGMD1` say what the stages compute.
    """

    # What the pixels need; every other parameter acts on MP(t) and F(t), which then need not be computed again.
    pixel_parameters: ClassVar[tuple[str, ...]]
    parameters: eqx.AbstractVar[Any]  # a ParameterSet
    thresholds: eqx.AbstractVar[Thresholds]
    n_p: eqx.AbstractVar[int]
    eye: eqx.AbstractVar[Eye | None]

    @abc.abstractmethod
    def _pixels_at_rest(self, frame: Map) -> Any:
        """The pixels with `frame`, their `luminance`, as what was seen before."""

    @abc.abstractmethod
    def _pixel_step(self, state: Any, frame: Map, interval: Scalar) -> tuple[Any, tuple[Scalar, Scalar, Any]]:
        """The next state of the pixels; the two sums of this frame, `mp` and the mean change, and its layers."""

    @abc.abstractmethod
    def _potentials(self, frames, interval, record: Record | None) -> tuple[Array, Array, Any]:
        """Both sums over a clip, and what was recorded."""

    @abc.abstractmethod
    def _cell_at_rest(self, dtype) -> Any:
        """The cell before the first frame."""

    @abc.abstractmethod
    def _cell_step(
        self, state: Any, mp: Scalar, f: Scalar, parameters: Any, interval: Scalar, pixels: int
    ) -> tuple[Any, dict[str, Scalar]]:
        """The next state of the cell and its channels; all numbers come in the cell's precision."""

    def __check_init__(self):
        kinds: dict[str, Any] = {field.name: field.type for field in dataclasses.fields(self)}
        for name in ("parameters", "thresholds", "eye"):
            if not isinstance(getattr(self, name), kinds[name]):
                raise ValueError(f"{name} is {getattr(self, name)!r}; give {kinds[name]!r}")
        self._check_persistence()

    def __repr__(self):
        thresholds = f"{type(self.thresholds).__name__}({getattr(self.thresholds, 'temperature', '')})"
        structure = [it.name for it in dataclasses.fields(self) if it.name not in ("parameters", "thresholds")]
        fields = ", ".join([thresholds, *(f"{name}={getattr(self, name)!r}" for name in structure)])
        return f"{type(self).__name__}({fields},\n{self.parameters})"

    def __call__(
        self,
        frames: Real[Array | np.ndarray, "time row col"],
        fps: Number | None = None,
        *,
        record: Record | None = None,
        check: bool = False,
    ) -> Response:
        """The response to a clip.

        **Arguments:**

        - `frames`: grey levels 0..255, at least 2 frames of at least 3 x 3 pixels. Pixels compute in this dtype
          (integers: in the parameters'), the cell in the promotion of it with the parameters'.
        - `fps`: frames per second, by default the eye's.
        - `record`: a function of the network's layers (`Layers` or `YueRindLayers`) that returns what to keep of every
          frame. A function is compiled once, so define it outside of a loop.
        - `check`: test the values inside a traced call too, at about twice the cost.

        **Raises:** `ValueError` for a wrong shape, and for concrete values that are not finite or out of their domain.
        """
        frames = _as_pixels(frames, self.parameters.k.dtype, "frames", "(time, row, col)", rank=3)
        if len(frames) < 2:
            count = "one frame" if len(frames) else "0 frames"
            raise ValueError(f"frames holds {count}; the network sees changes, so give at least 2")
        interval = self._interval(fps)
        check_domains(self.parameters)
        self._check_persistence()
        response = _respond(self, frames, interval, record)
        return self._checked(response, interval, check)

    def init(self, frame: Real[Array | np.ndarray, "row col"]) -> State:
        """The state before the first frame: at rest, with `frame` as what was seen before, L(-1).

        `step(init(frames[0]), frames[0], fps)` is the first output of a clip.

        **Raises:** `ValueError` for a wrong shape.
        """
        frame = _as_pixels(frame, self.parameters.k.dtype, "frame", "(row, col)", rank=2)
        return State(self._pixels_at_rest(frame), self._cell_at_rest(self._cell_dtype(frame)))

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

        **Raises:** `ValueError` as for a call, and for a frame of another size than the state's.
        """
        frame = _as_pixels(frame, self.parameters.k.dtype, "frame", "(row, col)", rank=2)
        if frame.shape != state.pixels.luminance.shape:
            raise ValueError(
                f"frame has shape {frame.shape}, the state {state.pixels.luminance.shape}; start anew with init(frame)"
            )
        if interval is None:
            interval = self._interval(fps)
        elif fps is not None:
            raise ValueError("fps and interval are both given; give the one that is known")
        else:
            interval = _positive(interval, "interval", "ms")
        state, response = _advance(self, state, frame, interval, record)
        return state, self._checked(response, interval, check)

    def _cell_dtype(self, pixels: Array):
        return jnp.result_type(pixels.dtype, self.parameters.k.dtype)

    def _cell(self, state, mp, f, interval, pixels: int) -> tuple[Any, dict[str, Array]]:
        """The cell in its own precision."""
        parameters, interval, mp, f = cast((self.parameters, interval, mp, f), self._cell_dtype(mp))
        return self._cell_step(state, mp, f, parameters, interval, pixels)

    def _interval(self, fps):
        if fps is None:
            if self.eye is None:
                raise ValueError("fps is missing; give it, or a model with an eye")
            fps = self.eye.fps
        interval = 1000 / _positive(fps, "fps", "frames per second")
        if self.eye is not None and is_concrete(fps) and abs(fps / self.eye.fps - 1) > 0.01:
            warnings.warn(f"the parameters belong to {self.eye.fps:g} frames per second, not {fps:g}", stacklevel=3)
        return interval

    def _check_persistence(self):
        if self.n_p and is_concrete(self.parameters.u):
            with jax.ensure_compile_time_eval():
                total = max(float(retina.persistence(u, self.n_p).sum()) for u in jnp.ravel(self.parameters.u))
            if total >= 1:
                raise ValueError(
                    f"u is {self.parameters.u} with n_p = {self.n_p}: the persistence sums to {total:.3g} and is "
                    "stable only below 1; raise u or lower n_p"
                )

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
            response = eqx.error_if(response, ~((interval > 0) & jnp.isfinite(interval)), "fps is not positive")
            for name, symbol in declared(type(self.parameters)).items():
                outside = ~symbol.contains(getattr(self.parameters, name))
                response = eqx.error_if(response, outside, f"{name} must lie in {symbol.domain}")
            unstable = retina.persistence(self.parameters.u, self.n_p).sum() >= 1
            response = eqx.error_if(response, unstable, "u is too low: the persistence sums to 1 or more")
        return response


AnyNetwork = TypeVar("AnyNetwork", bound=Network)


@eqx.filter_jit
def _respond(network: Network, frames, interval, record) -> Response:
    network, interval = _opaque((network, interval))
    mp, f, recorded = potentials(network, frames, interval, record)
    return Response(**channels(network, mp, f, interval, frames[0].size), recorded=recorded)


def potentials(network: Network, frames, interval, record: Record | None = None) -> tuple[Array, Array, Any]:
    """The pixel stage over a clip: MP(t), F(t) and what was recorded."""
    return network._potentials(frames, interval, record)


def channels(network: Network, mp, f, interval, pixels: int) -> dict[str, Array]:
    """The cell over a clip, from MP(t) and F(t): the channels of a `Response`."""

    def step(state, sums):
        mp, f = sums
        return network._cell(state, mp, f, interval, pixels)

    return jax.lax.scan(step, network._cell_at_rest(network._cell_dtype(mp)), (mp, f))[1]


@eqx.filter_jit
def _advance(network: Network, state: State, frame, interval, record) -> tuple[State, Response]:
    network, interval = _opaque((network, interval))
    pixels, (mp, f, layers) = network._pixel_step(state.pixels, frame, interval)
    cell, channels = network._cell(state.cell, mp, f, interval, frame.size)
    return State(pixels, cell), Response(**channels, recorded=None if record is None else record(layers))


def _opaque(tree):
    """The same, but never folded as a constant: so closed-over and passed parameters round alike, to the bit.

    One barrier a leaf: a common one would spread a tangent of one leaf over all of them.
    """
    arrays, rest = eqx.partition(tree, eqx.is_array)
    return eqx.combine(jax.tree.map(jax.lax.optimization_barrier, arrays), rest)


def _as_pixels(frames, dtype, name: str, shape: str, rank: int) -> Array:
    """Frames in the dtype in which pixels compute, `dtype` for integers, their shape checked."""
    try:
        frames = jnp.asarray(frames)
    except TypeError:
        raise ValueError(f"{name} is {frames!r:.40}; give an array of grey levels as {shape}") from None
    if frames.ndim != rank:
        raise ValueError(f"{name} has shape {frames.shape}; give grey levels as {shape}")
    if min(frames.shape[-2:]) < 3:
        raise ValueError(f"{name} has shape {frames.shape}; the lateral spread needs at least 3 rows and 3 columns")
    if jnp.issubdtype(frames.dtype, jnp.integer):
        return frames.astype(dtype)
    if frames.dtype not in (jnp.float32, jnp.float64):
        raise ValueError(f"{name} has dtype {frames.dtype}; give integers, float32 or float64")
    return frames


def _positive(value, name: str, unit: str) -> Array:
    """A strong array, so that another value does not compile again; checked where it is concrete."""
    if isinstance(value, str) or (is_concrete(value) and not (np.ndim(value) == 0 and 0 < value < np.inf)):
        raise ValueError(f"{name} is {value!r}; give a positive number of {unit}")
    return jnp.asarray(value, dtype=float)
