"""The evidence for an alarm over a clip that is decoded while it is judged: memory holds one block of its frames."""

from collections.abc import Iterable, Iterator

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float, Float32

from lgmd2jax._network.abstract import State
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._video.clip import Clip
from lgmd2jax._video.recording import Timeline
from lgmd2jax.alarms._evidence import evidence, spikes_for_alarm

_BLOCK = 64  # frames that go to the network together
Moment = tuple[Float32[np.ndarray, "row col"], float]  # a grey frame, and ms since the one before


def streamed_evidence(model: LGMD2, clip: Clip) -> tuple[Timeline, Float[np.ndarray, " time"]]:
    """The times of a clip's frames and the evidence in each, without the frames that are marked as repeated."""
    times, count = [], 0

    def moments() -> Iterator[Moment]:
        nonlocal count
        for frame in clip:
            count += 1
            if not frame.repeated:
                times.append((frame.index, frame.time, frame.interval))
                yield frame.grey.astype(np.float32), frame.interval

    u = np.concatenate(list(_potentials(model, moments())))
    index, time, interval = map(np.array, zip(*times, strict=True))
    trace = evidence(u, model.parameters.sigma_sp, spikes_for_alarm(model), model.N_ts)
    return Timeline(index, time, interval, clip.effective_fps, count), np.asarray(trace)


def _potentials(model: LGMD2, moments: Iterable[Moment]) -> Iterator[Float[np.ndarray, " frame"]]:
    """U' (eq. 15), block by block."""
    state, block = None, []
    for moment in moments:
        state = model.init(moment[0]) if state is None else state
        block.append(moment)
        if len(block) == _BLOCK:
            state, u = _advance(model, state, *_stacked(block))
            yield np.asarray(u)
            block = []
    if state is not None and block:
        # The last frame is held to the block's end, so that one length is compiled.
        _, u = _advance(model, state, *_stacked(block + [block[-1]] * (_BLOCK - len(block))))
        yield np.asarray(u)[: len(block)]


def _stacked(block: list[Moment]) -> tuple[Float32[np.ndarray, "frame row col"], Float[np.ndarray, " frame"]]:
    frames, intervals = zip(*block, strict=True)
    return np.stack(frames), np.array(intervals)


@eqx.filter_jit
def _advance(
    model: LGMD2,
    state: State,
    frames: Float32[Array | np.ndarray, "frame row col"],
    intervals: Float[Array | np.ndarray, " frame"],
) -> tuple[State, Float[Array, " frame"]]:
    """The state after a block of frames, and U' in each."""

    def step(state, moment):
        frame, interval = moment
        state, response = model.step(state, frame, interval=interval)
        return state, response.smp_adapted

    return jax.lax.scan(step, state, (frames, intervals))
