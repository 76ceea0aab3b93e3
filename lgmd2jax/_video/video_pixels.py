"""The pixels of a decoded frame, converted and scaled by ffmpeg when they are asked for."""

from fractions import Fraction

import numpy as np

from lgmd2jax._video.grey import Grey, Picture, area_average, grey
from lgmd2jax._video.image_pixels import ImagePixels, remarks_on_depth
from lgmd2jax._video.orientation import Orientation, Window

_FULL_RANGE = 2  # AVCOL_RANGE_JPEG


class Scaler:
    """ffmpeg's scaler `area`, which keeps what it has set up from frame to frame."""

    def __init__(self):
        from av.video.reformatter import VideoReformatter

        self._reformatter = VideoReformatter()
        self._crops: dict = {}

    def rgb(self, frame, window: Window | None = None, shape: tuple[int, int] | None = None) -> np.ndarray:
        """Red, green and blue of a window in 16 bits: (row, col, 3)."""
        if window is not None:
            frame = self._cropped(frame, window)
        rows, cols = shape or (frame.height, frame.width)
        # Other formats of 16 bits lose the low bits of some inputs.
        scaled = self._reformatter.reformat(frame, cols, rows, "gbrp16le", interpolation="AREA")
        return scaled.to_ndarray()

    def _cropped(self, frame, window: Window):
        rows, cols = window
        key = (rows.start, rows.stop, cols.start, cols.stop, frame.width, frame.height, frame.format.name)
        if key not in self._crops:
            self._crops[key] = _crop(frame, *key[:4])
        self._crops[key].vpush(frame)
        return self._crops[key].vpull()


class VideoPixels:
    """A frame as it is shown. `aspect`: how much wider than high a stored pixel is; `white`: as the user told it."""

    def __init__(self, frame, scaler: Scaler, orientation: Orientation, aspect: float, white: float | int | None):
        self._frame = frame
        self._scaler = scaler
        self._orientation = orientation
        self._white = white
        self._bits = frame.format.components[0].bits
        self._has_colour_differences = any(part.is_chroma for part in frame.format.components)
        self._has_alpha = any(part.is_alpha for part in frame.format.components)
        self.size = orientation.shape((frame.height, frame.width))
        self.aspect = 1 / aspect if orientation.transposed else aspect

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a user should know of this frame."""
        remarks = self._composite().remarks if self._has_alpha else ()
        if self._frame.interlaced_frame:
            remarks += ("it is interlaced, and two fields are taken for one frame; separate them first: -vf bwdif",)
        if 8 < self._bits <= 16 and not self._has_colour_differences:
            brightest = float(self._scaler.rgb(self._frame).max()) / self._ffmpegs_white() * self._largest
            remarks += tuple(remarks_on_depth(round(brightest), self._largest, self._white))
        return remarks

    def picture(self) -> Picture:
        """The whole frame in 8 bits."""
        if self._has_alpha:
            return self._composite().picture()
        if self._white is not None:
            return np.round(self._orientation.shown(self._levels())).astype(np.uint8)
        return self._orientation.shown(self._frame.to_ndarray(format="rgb24"))

    def grey(self, window: Window, shape: tuple[int, int]) -> Grey:
        """Grey levels 0..255 of a window, averaged to a shape."""
        edges = [part.indices(edge)[:2] for part, edge in zip(window, self.size, strict=True)]
        whole_pixels = shape == tuple(stop - start for start, stop in edges)
        if self._has_alpha:
            return self._composite().grey(window, shape)
        if not 8 <= self._bits <= 16 or (self._bits == 8 and whole_pixels and self._white is None):
            return area_average(grey(self.picture()[window]), shape)
        is_whole = edges == [(0, edge) for edge in self.size]
        part = None if is_whole else self._orientation.stored(window, self.size)
        return grey(self._orientation.shown(self._levels(part, self._orientation.shape(shape))))

    @property
    def _largest(self) -> int:
        return 2**self._bits - 1

    def _composite(self) -> ImagePixels:
        """A frame with transparency, laid on white."""
        stored = self._orientation.shown(self._frame.to_ndarray(format="rgba"))
        colours, cover = stored[..., :3], np.float32(stored[..., 3:]) / 255
        if (cover == 1).all():
            return ImagePixels(colours, 255.0)
        remark = "it is transparent in places, and is shown on white"
        return ImagePixels(colours * cover + 255 * (1 - cover), 255.0, (remark,))

    def _levels(self, window: Window | None = None, shape: tuple[int, int] | None = None) -> np.ndarray:
        """Red, green and blue as stored, 0 to 255 in all bits of the file: (row, col, 3)."""
        white = float(self._ffmpegs_white())
        if self._white is not None:
            self._check_white()
            white *= self._white / self._largest
        levels = self._scaler.rgb(self._frame, window, shape).astype(np.float32) * np.float32(255 / white)
        if self._white is not None and levels.max() > 255.5:
            brightest = float(levels.max()) / 255 * self._white
            raise ValueError(f"a frame holds {brightest:.0f}, above white = {self._white:g}; give the largest value")
        return np.minimum(levels, 255)

    def _ffmpegs_white(self) -> int:
        """White in the scaler's 16 bits: it shifts shallower values up."""
        full_range = self._frame.color_range == _FULL_RANGE or self._frame.format.name.startswith("yuvj")
        if self._has_colour_differences and not full_range:
            return 255 << 8
        return self._largest << (16 - self._bits)

    def _check_white(self) -> None:
        if self._has_colour_differences:
            raise ValueError(f"white is {self._white:g}, but {self._frame.format.name} states its own; leave it out")
        if self._white is not None and self._white > self._largest:
            raise ValueError(f"white is {self._white:g}, but the values of the video end at {self._largest}")


def _crop(frame, top: int, bottom: int, left: int, right: int):
    from av.filter import Graph

    graph = Graph()
    source = graph.add_buffer(
        width=frame.width, height=frame.height, format=frame.format, time_base=frame.time_base or Fraction(1, 1000)
    )
    crop = graph.add("crop", f"{right - left}:{bottom - top}:{left}:{top}:exact=1")
    sink = graph.add("buffersink")
    source.link_to(crop)
    crop.link_to(sink)
    graph.configure()
    return graph
