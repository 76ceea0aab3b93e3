"""A copy of the clip with the cell's trace and its alarm drawn on it."""

import contextlib
import os
from collections import deque
from collections.abc import Iterator
from fractions import Fraction

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from lgmd2jax._network.parameters import ParameterSet
from lgmd2jax._video.clip import Frame
from lgmd2jax._video.pictures import Picture
from lgmd2jax._video.trace import Row

# As in the figures.
_BLUE, _VERMILION, _BLACK, _WHITE = (86, 180, 233), (213, 94, 0), (0, 0, 0), (255, 255, 255)
_SECONDS = 4.0
_TICKS = 90_000


class Overlay:
    """Draws on frame after frame: the SMP of the last seconds in a band at the foot, and a red border in an alarm."""

    def __init__(self, size: tuple[int, int], parameters: ParameterSet):
        self._rows, self._cols = size
        self._levels = parameters.levels.spikes
        self._band = max(24, self._rows // 4)
        self._font = ImageFont.load_default(max(9, self._rows // 20))
        self._past: deque[Row] = deque()

    def draw(self, frame: Frame, row: Row) -> Picture:
        """The picture of this frame, with what the cell did up to it; `row` is the last that the cell answered."""
        if not frame.repeated:
            self._past.append(row)
        while self._past[0].time_ms < frame.time - 1000 * _SECONDS:
            self._past.popleft()
        shaded = frame.picture.copy()
        shaded[-self._band :] //= 3
        image = Image.fromarray(shaded)
        pen = ImageDraw.Draw(image)
        for level in self._levels:
            self._dashes(pen, self._y(level))
        curve = [(self._x(past, frame), self._y(past.smp_adapted)) for past in self._past]
        pen.line(curve, fill=_BLUE, width=max(2, self._rows // 120), joint="curve")
        foot = self._rows - 1
        for past in self._past:
            x, height = self._x(past, frame), past.spikes * self._band / 16
            if past.spikes:
                pen.line([(x, foot - height), (x, foot)], fill=_WHITE)
        short = f"frame {frame.index}"
        full = f"{short}  {frame.time / 1000:.2f} s  SMP {row.smp_adapted:.2f}"
        self._label(pen, 4.0, full if pen.textlength(full, self._font) < 0.7 * self._cols else short, _BLACK)
        if row.collision:
            pen.rectangle([0, 0, self._cols - 1, foot], outline=_VERMILION, width=max(2, self._rows // 60))
            self._label(pen, self._cols - 6 - pen.textlength("ALARM", self._font), "ALARM", _VERMILION)
        return np.asarray(image)

    def _x(self, past: Row, now: Frame) -> float:
        return (self._cols - 1) * (1 - (now.time - past.time_ms) / (1000 * _SECONDS))

    def _y(self, smp: float) -> float:
        """The band spans SMP .5 to 1, with room for the spikes below."""
        low, high = self._rows - 1 - self._band / 6, self._rows - self._band + 2
        return low + (high - low) * (smp - 0.5) / 0.5

    def _dashes(self, pen, y: float) -> None:
        step = max(4, self._cols // 60)
        for x in range(0, self._cols, 2 * step):
            pen.line([(x, y), (x + step, y)], fill=_VERMILION)

    def _label(self, pen, x: float, text: str, ground: tuple[int, int, int]) -> None:
        left, top, right, bottom = pen.textbbox((x, 4), text, self._font)
        pen.rectangle([left - 3, top - 2, right + 3, bottom + 2], fill=ground)
        pen.text((x, 4), text, _WHITE, self._font)


class VideoWriter:
    """Encodes pictures at their own times. h264 needs even sizes, so an odd edge is repeated once."""

    def __init__(self, container, fps: float):
        self._container = container
        self._fps = fps
        self._stream = None

    def write(self, picture: Picture, time: float) -> None:
        """Append a picture that is shown from `time`, in ms."""
        import av

        picture = np.pad(picture, [(0, picture.shape[0] % 2), (0, picture.shape[1] % 2), (0, 0)], mode="edge")
        if self._stream is None:
            rate = Fraction(self._fps).limit_denominator(1001)
            stream = self._container.add_stream("libx264", rate=rate, options={"crf": "20"})
            stream.height, stream.width = picture.shape[:2]
            stream.pix_fmt = "yuv420p"
            stream.codec_context.time_base = Fraction(1, _TICKS)
            self._stream = stream
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
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
    try:
        import av
        from av.error import FFmpegError
    except ImportError:
        raise ValueError("writing video needs PyAV: pip install 'lgmd2jax[video]'") from None
    try:
        container = av.open(os.fspath(path), "w")
    except (ValueError, FFmpegError):
        raise ValueError("cannot tell the format of the video; end its name in .mp4, .mkv or .mov") from None
    with container:
        writer = VideoWriter(container, fps)
        yield writer
        writer.close()
