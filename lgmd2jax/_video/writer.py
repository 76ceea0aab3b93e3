"""Pictures into a video file, each at its own time."""

import contextlib
import os
from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from lgmd2jax._pyav import pyav
from lgmd2jax._video.grey import Picture

_TICKS = 90_000  # a second
_CODEC = "libx264"
_CURE = "end its name in .mp4, .mkv or .mov"


class VideoWriter:
    """Encodes pictures at their own times. h264 needs even sizes, so an odd edge is repeated once."""

    def __init__(self, av, container, fps: float):
        self._av, self._container = av, container
        self._fps = fps
        self._stream = None

    def write(self, picture: Picture, time: float) -> None:
        """Append a picture that is shown from `time`, in ms."""
        picture = np.pad(picture, [(0, picture.shape[0] % 2), (0, picture.shape[1] % 2), (0, 0)], mode="edge")
        if self._stream is None:
            rate = Fraction(self._fps).limit_denominator(1001)
            stream = self._container.add_stream(_CODEC, rate=rate, options={"crf": "20"})
            stream.height, stream.width = picture.shape[:2]
            stream.pix_fmt = "yuv420p"
            stream.codec_context.time_base = Fraction(1, _TICKS)
            self._stream = stream
        frame = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
        frame.pts, frame.time_base = round(time / 1000 * _TICKS), Fraction(1, _TICKS)
        self._container.mux(self._stream.encode(frame))

    def close(self) -> None:
        """Write what the encoder still holds."""
        if self._stream is not None:
            self._container.mux(self._stream.encode(None))


@contextlib.contextmanager
def video_writer(path: str | os.PathLike, fps: float) -> Iterator[VideoWriter]:
    """A video file to write pictures to, complete when the block ends well.

    **Raises:** `ValueError` without PyAV, and for a name whose suffix is no video format.
    """
    av = pyav("writing video needs")
    try:
        container = av.open(os.fspath(path), "w")
    except (ValueError, av.error.FFmpegError):
        raise ValueError(f"cannot tell the format of the video; {_CURE}") from None
    with container:
        if _CODEC not in container.supported_codecs:
            raise ValueError(f"no {container.format.name} file holds H.264; {_CURE}")
        writer = VideoWriter(av, container, fps)
        yield writer
        writer.close()
