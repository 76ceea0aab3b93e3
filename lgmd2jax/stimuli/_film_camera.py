"""What a camera and its file make of light: exposure, contrast, flicker, noise, H.264, 8 bits, repeated frames."""

import io
import itertools

import numpy as np
from jaxtyping import Float, Int, Real, UInt8

from lgmd2jax._pyav import pyav
from lgmd2jax.stimuli._camera import FILM_BY_FILE
from lgmd2jax.stimuli._film_scene import coarse
from lgmd2jax.stimuli._shot import Course, Shot

_COMPRESSED = 0.5  # of the films
_CRF = 10, 22  # x264's measure of what it leaves out; on frames so small it leaves out more than from a whole picture
_EXPOSED = 0.7  # of the films: by a camera that follows the light
_CONVERTED = 0.1  # of the films: they keep frames that the conversion to a faster file repeated


def recorded(light: Float[np.ndarray, "time row col"], shot: Shot) -> UInt8[np.ndarray, "time _row _col"]:
    """The frames in the file, of the light on the finer raster of `draw`.

    What is random is the same at any frame rate, but for the noise.

    **Raises:** `ValueError` without PyAV.
    """
    of_frames = light.mean(axis=(1, 2))
    contrast, middle = shot.log(1.2, 2.2), min(shot.between(80, 110), float(of_frames.mean()))
    flicker = shot.log(3e-4, 2e-3) if shot.often(0.5) else 0.0
    beat = np.sin(2 * np.pi * shot.between(0.5, 12) * shot.time)
    gain = _exposure(of_frames, shot) * (1 + flicker * beat)
    exposed = middle + contrast * (light * gain[:, None, None] - middle)
    noise = np.random.default_rng(shot.chance.integers(2**32)).standard_normal(light.shape, np.float32)
    # Photons come by chance: where there are more of them, their number varies more.
    noise *= shot.log(0.3, 3) * np.sqrt(np.clip(exposed, 10, 255) / 128)
    frames = _in_8_bits(exposed + noise)
    crf, compressed = int(shot.chance.integers(*_CRF)), shot.often(_COMPRESSED)
    repeats, ratio = shot.often(_CONVERTED), float(shot.chance.choice(FILM_BY_FILE))
    if repeats:
        frames = frames[_sources(len(frames), ratio)]
    return _in_8_bits(coarse(_as_h264(frames, crf) if compressed else frames))


def _exposure(light: Course, shot: Shot) -> Course:
    """The factor by which a camera evens out a change of the mean light, in part and with a lag."""
    strength, lag = shot.between(0.3, 1.0) * shot.often(_EXPOSED), shot.log(0.2, 1.5)
    share = 1 - np.exp(-(shot.time[1] - shot.time[0]) / lag)
    followed = np.array(list(itertools.accumulate(light, lambda seen, now: seen + share * (now - seen))))
    return (light[0] / followed) ** strength


def _in_8_bits(levels: Real[np.ndarray, "time row col"]) -> UInt8[np.ndarray, "time row col"]:
    return np.round(np.clip(levels, 0, 255)).astype(np.uint8)


def _sources(count: int, ratio: float) -> Int[np.ndarray, " time"]:
    """Which frame each shows that ought to show its own, of a film with so many frames for each of the file's."""
    return (np.floor(np.arange(count) * ratio) / ratio).astype(int)


def _as_h264(frames: UInt8[np.ndarray, "time row col"], crf: int) -> UInt8[np.ndarray, "time row col"]:
    """The frames encoded and decoded, in memory.

    By one thread in plain C: with more threads, or x264's code for vector registers, the bits differ from run to run.
    """
    av = pyav("rendered films pass through H.264, which needs")
    file = io.BytesIO()
    with av.open(file, "w", format="matroska") as container:
        options = {"crf": str(crf), "preset": "veryfast", "threads": "1", "x264-params": "asm=0"}
        stream = container.add_stream("libx264", rate=30, options=options)
        stream.height, stream.width = frames.shape[1:]
        stream.pix_fmt = "yuv420p"
        for frame in frames:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="gray8")))
        container.mux(stream.encode(None))
    file.seek(0)
    with av.open(file, "r") as written:
        return np.stack([frame.to_ndarray(format="gray8") for frame in written.decode(video=0)])
