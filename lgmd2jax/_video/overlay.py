"""A copy of the clip with the cell's trace and its alarm drawn on it."""

from collections import deque

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._video.clip import Frame
from lgmd2jax._video.grey import Picture
from lgmd2jax._video.trace import Row

# As in the figures.
_BLUE, _VERMILION, _BLACK, _WHITE = (86, 180, 233), (213, 94, 0), (0, 0, 0), (255, 255, 255)
_SECONDS = 4.0


class Overlay:
    """Draws on frame after frame: the SMP of the last seconds in a band at the foot, and a red border in an alarm."""

    def __init__(self, size: tuple[int, int], model: AbstractNetwork):
        self._rows, self._cols = size
        self._levels = model.levels.spikes
        self._band = max(24, self._rows // 4)
        self._font = ImageFont.load_default(max(9, min(size) // 20))
        self._border = max(2, min(size) // 60)
        self._inset = 4.0 + self._border  # of the labels, which the border would hide
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
        self._label(pen, self._inset, full if pen.textlength(full, self._font) < 0.7 * self._cols else short, _BLACK)
        if row.collision:
            pen.rectangle([0, 0, self._cols - 1, foot], outline=_VERMILION, width=self._border)
            self._label(pen, self._cols - self._inset - pen.textlength("ALARM", self._font), "ALARM", _VERMILION)
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
        left, top, right, bottom = pen.textbbox((x, self._inset), text, self._font)
        pen.rectangle([left - 3, top - 2, right + 3, bottom + 2], fill=ground)
        pen.text((x, self._inset), text, _WHITE, self._font)
