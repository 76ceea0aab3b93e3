"""The LGMD2: one frame is `step`, a clip is `jax.lax.scan` over frames of the same two steps."""

import warnings
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Real

from lgmd2jax import _retina as retina
from lgmd2jax._eye import Eye
from lgmd2jax._lobula import CellState, cell_step
from lgmd2jax._low_pass import LOW_PASS_FORMS, LowPass
from lgmd2jax._parameters import Parameters, check_domains, is_concrete, nearest, symbols
from lgmd2jax._pixels import PixelState, Record, cast, pixel_step
from lgmd2jax._sensitivity import potentials
from lgmd2jax._thresholds import Hard, Thresholds


class State(eqx.Module):
    """All that the network keeps from one frame to the next."""

    pixels: PixelState
    cell: CellState


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


Number = float | int | np.number | Real[Array | np.ndarray, ""]


class LGMD2(eqx.Module):
    """The collision-selective network of Fu, Hu & Yue, differentiable and streaming.

    ```python
    model = LGMD2()                                    # Table I, hard thresholds
    response = model(frames, fps)                      # a clip
    state = model.init(frame)                          # the same numbers, a frame at a time
    state, now = model.step(state, frame, fps)
    jax.vmap(model, in_axes=(0, None))(clips, fps)     # a batch
    ```

    **Arguments:**

    - `parameters`: the paper's parameters; they belong to a frame rate and a field of view.
    - `thresholds`: `Hard()`, `Soft(temperature)` or `StraightThrough(temperature)`.
    - `n_p`: number of frames that a change of luminance persists (eq. 1).
    - `low_pass`: how the delays are discretised, `"backward_euler"` or `"exact"` (eqs 4, 14).
    - `N_ts`: number of past frames in which spikes are counted for an alarm (eq. 17).
    - `eye`: the sampling that the parameters belong to; where it is given, `fps` may be left out of a call.

    **Raises:** `ValueError` for structure that does not exist and for persistence that is not stable.
    """

    parameters: Parameters = eqx.field(default_factory=Parameters)
    thresholds: Thresholds = eqx.field(default_factory=Hard)
    n_p: int = eqx.field(default=0, static=True)
    low_pass: LowPass = eqx.field(default="backward_euler", static=True)
    N_ts: int = eqx.field(default=4, static=True)
    eye: Eye | None = eqx.field(default=None, static=True)

    def __check_init__(self):
        for name, kind in (("parameters", Parameters), ("thresholds", Thresholds), ("eye", Eye | None)):
            if not isinstance(getattr(self, name), kind):
                raise ValueError(f"{name} is {getattr(self, name)!r}; give {kind!r}")
        for name in ("n_p", "N_ts"):
            if not isinstance(getattr(self, name), int) or getattr(self, name) < 0:
                raise ValueError(f"{name} is {getattr(self, name)!r}; give a whole number of frames, 0 or more")
        if self.low_pass not in LOW_PASS_FORMS:
            raise ValueError(f"low_pass is {self.low_pass!r}; choose {nearest(self.low_pass, LOW_PASS_FORMS)}")
        self._check_persistence()

    def __repr__(self):
        thresholds = f"{type(self.thresholds).__name__}({getattr(self.thresholds, 'temperature', '')})"
        structure = f"n_p={self.n_p}, low_pass={self.low_pass!r}, N_ts={self.N_ts}, eye={self.eye}"
        return f"LGMD2({thresholds}, {structure},\n{self.parameters})"

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
        - `record`: a function of `Layers` that returns what to keep of every frame. A function is compiled once, so
          define it outside of a loop.
        - `check`: test the values inside a traced call too, at about twice the cost.

        **Raises:** `ValueError` for a wrong shape, and for concrete values that are not finite or out of their domain.
        """
        frames = _as_pixels(frames, self.parameters, "frames", "(time, row, col)", rank=3)
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
        frame = _as_pixels(frame, self.parameters, "frame", "(row, col)", rank=2)
        return State(PixelState.rest(frame, self.n_p), CellState.rest(self.N_ts, self._cell_dtype(frame)))

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
        frame = _as_pixels(frame, self.parameters, "frame", "(row, col)", rank=2)
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

    def _cell_dtype(self, frame):
        return jnp.result_type(frame.dtype, self.parameters.tau1.dtype)

    def _cell_step(self, state: CellState, mp, f, interval, pixels: int) -> tuple[CellState, dict]:
        """Eqs 12-17 in the cell's own precision."""
        dtype = state.u.dtype
        parameters, interval, mp, f = cast((self.parameters, interval, mp, f), dtype)
        return cell_step(state, mp, f, parameters, self.thresholds, interval, pixels, self.low_pass)

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
            for name, symbol in symbols().items():
                outside = ~symbol.contains(getattr(self.parameters, name))
                response = eqx.error_if(response, outside, f"{name} must lie in {symbol.domain}")
            unstable = retina.persistence(self.parameters.u, self.n_p).sum() >= 1
            response = eqx.error_if(response, unstable, "u is too low: the persistence sums to 1 or more")
        return response


@eqx.filter_jit
def _respond(model: LGMD2, frames, interval, record) -> Response:
    model, interval = _opaque((model, interval))
    mp, f, recorded = potentials(model, frames, interval, record)
    return Response(**channels(model, mp, f, interval, frames[0].size), recorded=recorded)


def channels(model: LGMD2, mp, f, interval, pixels: int) -> dict[str, Array]:
    """The cell over a clip, from MP(t) and F(t): the channels of a `Response`."""

    def step(state, sums):
        mp, f = sums
        return model._cell_step(state, mp, f, interval, pixels)

    dtype = jnp.result_type(mp.dtype, model.parameters.tau1.dtype)
    return jax.lax.scan(step, CellState.rest(model.N_ts, dtype), (mp, f))[1]


@eqx.filter_jit
def _advance(model: LGMD2, state: State, frame, interval, record) -> tuple[State, Response]:
    model, interval = _opaque((model, interval))
    pixels, (mp, f, layers) = pixel_step(model, state.pixels, frame, interval)
    cell, channels = model._cell_step(state.cell, mp, f, interval, frame.size)
    return State(pixels, cell), Response(**channels, recorded=None if record is None else record(layers))


def _opaque(tree):
    """The same, but never folded as a constant: so closed-over and passed parameters round alike, to the bit.

    One barrier a leaf: a common one would spread a tangent of one leaf over all of them.
    """
    arrays, rest = eqx.partition(tree, eqx.is_array)
    return eqx.combine(jax.tree.map(jax.lax.optimization_barrier, arrays), rest)


def _as_pixels(frames, parameters: Parameters, name: str, shape: str, rank: int) -> Array:
    """Frames in the dtype in which pixels compute, their shape checked."""
    try:
        frames = jnp.asarray(frames)
    except TypeError:
        raise ValueError(f"{name} is {frames!r:.40}; give an array of grey levels as {shape}") from None
    if frames.ndim != rank:
        raise ValueError(f"{name} has shape {frames.shape}; give grey levels as {shape}")
    if min(frames.shape[-2:]) < 3:
        raise ValueError(f"{name} has shape {frames.shape}; the lateral spread needs at least 3 rows and 3 columns")
    if jnp.issubdtype(frames.dtype, jnp.integer):
        return frames.astype(parameters.tau1.dtype)
    if frames.dtype not in (jnp.float32, jnp.float64):
        raise ValueError(f"{name} has dtype {frames.dtype}; give integers, float32 or float64")
    return frames


def _positive(value, name: str, unit: str) -> Array:
    """A strong array, so that another value does not compile again; checked where it is concrete."""
    if isinstance(value, str) or (is_concrete(value) and not (np.ndim(value) == 0 and 0 < value < np.inf)):
        raise ValueError(f"{name} is {value!r}; give a positive number of {unit}")
    return jnp.asarray(value, dtype=float)
