"""A clip as the model sees it: grey frames with their times, one at a time, whatever the length of the file."""

import dataclasses
import functools
import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np
from jaxtyping import Bool, Float

from lgmd2jax._video.grey import Grey, Picture
from lgmd2jax._video.orientation import Window
from lgmd2jax._video.pictures import Pictures, Pixels, open_pictures
from lgmd2jax._video.recording import Recording
from lgmd2jax._video.remarks import warn
from lgmd2jax._video.repeats import find_repeats
from lgmd2jax._video.video_file import VideoFile

# Containers round time stamps to a millisecond: a stamp so near to the regular clock says nothing against it.
_ROUNDING_MS = 1.0
# Codecs want even sizes, so that square pixels come out a little off.
_NEARLY_SQUARE = 0.03
# Changes between frames are as clear in a smaller picture, and cost less.
_WIDTH_OF_CHANGES = 640


@dataclasses.dataclass(frozen=True)
class Frame:
    """One frame of a clip.

    - `index`: its place in the file, from 0; repeats count.
    - `time`: ms since the first frame, by the file's clock.
    - `interval`: ms since the last frame that was no repeat, for the model's time constants.
    - `pixels`: the whole frame, to be converted on demand.
    - `grey`: what the model sees: cropped, grey levels 0..255 by ITU-R 601, resized.
    - `repeated`: whether it repeats the frame before it, and is to be passed over.
    """

    index: int
    time: float
    interval: float
    pixels: Pixels
    grey: Float[np.ndarray, "height width"]
    repeated: bool

    @functools.cached_property
    def picture(self) -> Picture:
        """The whole picture, 8-bit RGB."""
        return self.pixels.picture()


@dataclasses.dataclass(frozen=True)
class Clip:
    """A video file or a folder of images, to be read by `for frame in clip`, from the start each time.

    Built by `open_clip`. Only one frame is held at a time.

    - `fps`: frames per second of the file, or as told.
    - `size`, `shape`: rows and columns of the picture, and of what the model sees.
    - `window`: the part of the picture that is used.
    - `told`: whether `fps` was told, so that the file's time stamps do not count.
    - `repeats`: which frames repeat the one before; None as long as nobody looked.
    - `regular`: whether the frames keep a steady clock; None as long as nobody looked.
    """

    name: str
    pictures: Pictures
    fps: float
    told: bool
    size: tuple[int, int]
    window: Window
    shape: tuple[int, int]
    repeats: Bool[np.ndarray, " time"] | None = None
    regular: bool | None = None

    @property
    def count(self) -> int | None:
        """How many frames to expect, where that is known."""
        return self.pictures.count if self.repeats is None else len(self.repeats)

    @property
    def most(self) -> int | None:
        """A number of frames that is not exceeded, where that is known without decoding."""
        if self.count is None and isinstance(self.pictures, VideoFile):
            return self.pictures.packets()
        return self.count

    @property
    def effective_fps(self) -> float:
        """The file's frames per second, times the share of frames that are no repeats."""
        return self.fps if self.repeats is None else self.fps * float(np.mean(~self.repeats))

    def __iter__(self) -> Iterator[Frame]:
        index, last = 0, None
        for index, time, pixels in self._timed():
            repeated = self.repeats is not None and bool(self.repeats[index])
            interval = self._interval(time, last)
            last = last if repeated else time
            yield Frame(index, time, interval, pixels, pixels.grey(self.window, self.shape), repeated)
        self._check_count(index + 1)

    def without_repeats(self, progress: Callable[[Iterable], Iterable] = iter) -> "Clip":
        """The clip with its repeated frames marked, at the cost of a pass over the file. `progress` wraps that pass."""
        times, changes, before = [], [], None
        for _, time, pixels in progress(self._timed()):
            before, change = self._change(pixels, before)
            times.append(time)
            changes.append(change)
        return self._marked(times, changes)

    def record(self, drop_repeats: bool = False) -> Recording:
        """All frames at once, from a single pass over the file; without the repeated ones, if wanted."""
        times, changes, frames, before = [], [], [], None
        for _, time, pixels in self._timed():
            if drop_repeats:
                before, change = self._change(pixels, before)
                changes.append(change)
            times.append(time)
            frames.append(pixels.grey(self.window, self.shape))
        self._check_count(len(frames))
        clip = self._marked(times, changes) if drop_repeats else self
        kept = np.arange(len(frames)) if clip.repeats is None else np.flatnonzero(~clip.repeats)
        shown = [times[index] for index in kept]
        intervals = [clip._interval(time, last) for time, last in zip(shown, [None, *shown], strict=False)]
        return Recording(
            frames=np.stack([frames[index] for index in kept]).astype(np.float32),
            index=kept,
            time=np.array(shown, float),
            interval=np.array(intervals, float),
            fps=clip.effective_fps,
            count=len(frames),
        )

    def _timed(self) -> Iterator[tuple[int, float, Pixels]]:
        """Index, time in ms and pixels. The regular clock holds wherever the file's stamps do not speak against it."""
        last = -math.inf
        for index, (pixels, stamp) in enumerate(self.pictures):
            if pixels.size != self.size:
                other, first = _text(pixels.size), _text(self.size)
                raise ValueError(f"{self.name}: frame {index} has {other} pixels, the first {first}; use one size")
            time = index * 1000 / self.fps
            if not self.told and stamp is not None and abs(stamp - time) > _ROUNDING_MS:
                time = stamp if stamp > last else last + 1000 / self.fps
            last = time
            yield index, time, pixels

    def _interval(self, time: float, last: float | None) -> float:
        """From the last frame to this one, in ms.

        Conversion repeats frames of a steady camera: its own rate is the effective one. Without a steady clock the
        stamps are what is known.
        """
        interval = 1000 / self.effective_fps if last is None or self.regular else time - last
        usual = 1000 / self.fps
        return usual if math.isclose(interval, usual, rel_tol=1e-9) else interval

    def _change(self, pixels: Pixels, before: Grey | None) -> tuple[Grey, float]:
        """The frame in grey, and the mean absolute difference to the one before."""
        height, width = (stop - start for start, stop in self._edges())
        share = min(1.0, _WIDTH_OF_CHANGES / width)
        now = pixels.grey(self.window, (max(1, round(share * height)), round(share * width)))
        return now, 0.0 if before is None else float(np.abs(now - before).mean())

    def _edges(self) -> list[tuple[int, int]]:
        return [part.indices(edge)[:2] for part, edge in zip(self.window, self.size, strict=True)]

    def _marked(self, times: Sequence[float], changes: Sequence[float]) -> "Clip":
        regular = all(time == index * 1000 / self.fps for index, time in enumerate(times))
        return dataclasses.replace(self, repeats=find_repeats(np.array(changes)), regular=regular)

    def _check_count(self, count: int) -> None:
        if count < 2:
            raise ValueError(f"{self.name} holds one frame; the network sees changes, so give at least 2")


def open_clip(
    path: str | os.PathLike,
    *,
    fps: float | int | None = None,
    crop: Window | None = None,
    resize: int | None = None,
    white: float | int | None = None,
    until_damage: bool = False,
) -> Clip:
    """A clip, ready to be read. Its first frame is read here, so that what is wrong shows before the work.

    What a user should know of the clip, such as interlacing, is a `ClipWarning`.

    **Arguments:**

    - `path`: any video that ffmpeg reads, a folder of images (in natural order), or a TIFF file of several pages.
    - `fps`: frames per second, instead of what the file and its time stamps say; a folder needs it.
    - `crop`: the rows and columns to use, such as `np.s_[20:200, 36:397]`.
    - `resize`: width in pixels of what the model sees, after the crop; the height follows, so that pixels become
      square. Each is the mean over its area.
    - `white`: the value that is white, such as 4095 for a camera of 12 bits whose images have 16; by default the
      largest that the format holds. Images of floats need it.
    - `until_damage`: whether to end the clip where the file is damaged or truncated, instead of refusing it.

    **Raises:** `ValueError` for what is no clip and for options that do not fit it, `FileNotFoundError` for no file.
    """
    name = os.fspath(path)
    if white is not None and not (math.isfinite(white) and white > 0):
        raise ValueError(f"white is {white}; give the positive value that is white, such as 4095 for 12 bits")
    pictures = open_pictures(path, white=white, until_damage=until_damage)
    first = next(iter(pictures), None)
    if first is None:
        raise ValueError(f"{name} holds no frame that can be read")
    pixels, _ = first
    size = pixels.size
    if fps is None and pictures.fps is None:
        raise ValueError(f"{name} states no frame rate; give it: fps = 30 (--fps 30)")
    rate = pictures.fps if fps is None else fps
    if rate is None or not (math.isfinite(rate) and rate > 0):
        raise ValueError(f"fps is {rate}; give a positive number of frames per second")
    window = crop or (slice(None), slice(None))
    aspect = nearly_square(pixels.aspect)
    shape = shape_after(name, size, window, resize, aspect)
    pixels.grey(window, shape)  # a white level that does not fit shows here
    remarks = [*pictures.remarks, *pixels.remarks]
    if fps is not None and rate < 1:
        remarks.append(f"fps is {rate:.4g}; were {1 / rate:.4g} frames per second meant, given as an interval in s?")
    if aspect != 1:
        done = "are taken for square; resize would make them so" if resize is None else "are made square"
        remarks.append(f"its pixels are {aspect:.3g} times as wide as high, and {done}")
    for remark in remarks:
        warn(f"{name}: {remark}")
    return Clip(name, pictures, float(rate), fps is not None, size, window, shape)


def nearly_square(aspect: float) -> float:
    """How much wider than high a pixel is, 1 where it is a little off."""
    return 1.0 if abs(aspect - 1) < _NEARLY_SQUARE else aspect


def shape_after(name: str, size: tuple[int, int], window: Window, resize: int | None, aspect: float) -> tuple[int, int]:
    """Rows and columns of what the model sees of a picture, after the crop.

    **Raises:** `ValueError` for a crop beyond the picture, and for what is left too small.
    """
    height, width = (_length(part, edge) for part, edge in zip(window, size, strict=True))
    if not (height and width):
        rows, cols = size
        asked = ",".join(f"{'' if s.start is None else s.start}:{'' if s.stop is None else s.stop}" for s in window)
        raise ValueError(f"crop {asked} does not lie in the frame; its rows are 0:{rows}, its columns 0:{cols}")
    shape = (height, width) if resize is None else (round(height * resize / (width * aspect)), resize)
    if min(shape) < 3:
        raise ValueError(f"{name} is {_text(shape)} pixels after crop and resize; the network needs at least 3 x 3")
    return shape


def window_of(text: str) -> Window:
    """The rows and columns that `TOP:BOTTOM,LEFT:RIGHT` names.

    **Raises:** `ValueError` for another text.
    """
    match = re.fullmatch(r"(\d*):(\d*),(\d*):(\d*)", text.replace(" ", ""))
    if match is None:
        raise ValueError(f"crop is {text!r}; write TOP:BOTTOM,LEFT:RIGHT in pixels, such as 20:200,36:397 or :,36:397")
    top, bottom, left, right = (int(edge) if edge else None for edge in match.groups())
    return slice(top, bottom), slice(left, right)


def _length(part: slice, edge: int) -> int:
    """How many pixels a slice takes of an edge; 0 where it reaches beyond it."""
    start, stop = part.start or 0, edge if part.stop is None else part.stop
    return stop - start if 0 <= start < stop <= edge else 0


def _text(shape: tuple[int, ...]) -> str:
    return f"{shape[0]} x {shape[1]}"
