"""The evidence for an alarm over a clip that is decoded while it is judged: memory holds one block of its frames."""

from collections.abc import Iterable, Iterator

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Float32

from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._network.abstract import State
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.stages import Response
from lgmd2jax._video.clip import Clip
from lgmd2jax._video.recording import Timeline
from lgmd2jax.alarms._evidence import evidence, spikes_for_alarm
from lgmd2jax.alarms._reasons import Drive, active_part, drive_of

_BLOCK = 64  # frames that go to the network together
Moment = tuple[Float32[np.ndarray, "row col"], float]  # a grey frame, and ms since the one before


def streamed_evidence(model: LGMD2, clip: Clip) -> tuple[Timeline, Float[np.ndarray, " time"], Drive]:
    """The times of a clip's frames, the evidence and what acts on the cell in each, without the repeated frames."""
    times, count = [], 0

    def moments() -> Iterator[Moment]:
        nonlocal count
        for frame in clip:
            count += 1
            if not frame.repeated:
                times.append((frame.index, frame.time, frame.interval))
                yield frame.grey.astype(np.float32), frame.interval

    response = jax.tree.map(lambda *blocks: np.concatenate(blocks), *_responses(model, moments()))
    index, time, interval = map(np.array, zip(*times, strict=True))
    film = Timeline(index, time, interval, clip.effective_fps, count)
    # The last frame is held to a power of two, so that few lengths are compiled.
    held = (1 << (len(index) - 1).bit_length()) - len(index)
    response, lasts = jax.tree.map(lambda channel: jnp.pad(channel, (0, held), mode="edge"), (response, interval))
    judged = _judged(model, response, lasts, clip.shape[0] * clip.shape[1], spikes_for_alarm(model))
    trace, drive = jax.tree.map(lambda channel: np.asarray(channel)[: len(index)], judged)
    return film, trace, drive


@traced_once
def _judged(
    model: LGMD2, response: Response, interval: Float[Array, " time"], pixels: int, N_sp: int
) -> tuple[Float[Array, " time"], Drive]:
    """The evidence in every frame, and what acts on the cell."""
    trace = evidence(response.smp_adapted, model.parameters.sigma_sp, N_sp, model.N_ts)
    return trace, drive_of(model, response.mp, response.ffi, response.recorded, interval, pixels, N_sp)


def _responses(model: LGMD2, moments: Iterable[Moment]) -> Iterator[Response]:
    """The response, with the part of the field that is active, block by block."""
    state, block = None, []
    for moment in moments:
        state = model.init(moment[0]) if state is None else state
        block.append(moment)
        if len(block) == _BLOCK:
            state, response = _advance(model, state, *_stacked(block))
            yield jax.device_get(response)
            block = []
    if state is not None and block:
        # The last frame is held to the block's end, so that one length is compiled.
        _, response = _advance(model, state, *_stacked(block + [block[-1]] * (_BLOCK - len(block))))
        yield jax.tree.map(lambda channel: np.asarray(channel)[: len(block)], response)


def _stacked(block: list[Moment]) -> tuple[Float32[np.ndarray, "frame row col"], Float[np.ndarray, " frame"]]:
    frames, intervals = zip(*block, strict=True)
    return np.stack(frames), np.array(intervals)


@traced_once
def _advance(
    model: LGMD2,
    state: State,
    frames: Float32[Array | np.ndarray, "frame row col"],
    intervals: Float[Array | np.ndarray, " frame"],
) -> tuple[State, Response]:
    """The state after a block of frames, and the response to each."""

    def step(state, moment):
        frame, interval = moment
        return model.step(state, frame, interval=interval, record=active_part)

    return jax.lax.scan(step, state, (frames, intervals))
