"""A clip as the model sees it: grey frames with their times, one at a time, whatever the length of the file."""

import dataclasses
import math
import os
import re
from collections.abc import Callable, Iterable, Iterator

import numpy as np
from jaxtyping import Bool, Float
from skimage.transform import resize as resized

from lgmd2jax._video.pictures import Picture, Pictures, open_pictures
from lgmd2jax._video.repeats import find_repeats

# Containers round time stamps to a millisecond: a stamp so near to the regular clock says nothing against it.
_ROUNDING_MS = 1.0


@dataclasses.dataclass(frozen=True)
class Frame:
    """One frame of a clip.

    - `index`: its place in the file, from 0; repeats count.
    - `time`: ms since the first frame, by the file's clock.
    - `interval`: ms since the last frame that was no repeat, for the model's time constants.
    - `picture`: the whole picture, 8-bit RGB.
    - `grey`: what the model sees: cropped, grey levels 0..255 by ITU-R 601, resized.
    - `repeated`: whether it repeats the frame before it, and is to be passed over.
    """

    index: int
    time: float
    interval: float
    picture: Picture
    grey: Float[np.ndarray, "height width"]
    repeated: bool


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
    window: tuple[slice, slice]
    shape: tuple[int, int]
    repeats: Bool[np.ndarray, " time"] | None = None
    regular: bool | None = None

    @property
    def count(self) -> int | None:
        """How many frames to expect, where that is known."""
        return self.pictures.count if self.repeats is None else len(self.repeats)

    @property
    def effective_fps(self) -> float:
        """The file's frames per second, times the share of frames that are no repeats."""
        return self.fps if self.repeats is None else self.fps * float(np.mean(~self.repeats))

    def __iter__(self) -> Iterator[Frame]:
        index, last = 0, None
        for index, time, picture in self._timed():
            repeated = self.repeats is not None and bool(self.repeats[index])
            # Conversion repeats frames of a steady camera: its own rate is the effective one. Without a steady clock
            # the stamps are what is known.
            interval = 1000 / self.effective_fps if last is None or self.regular else time - last
            if math.isclose(interval, 1000 / self.fps, rel_tol=1e-9):
                interval = 1000 / self.fps
            last = last if repeated else time
            yield Frame(index, time, interval, picture, self._seen(picture), repeated)
        if index == 0:
            raise ValueError(f"{self.name} holds one frame; the network sees changes, so give at least 2")

    def without_repeats(self, progress: Callable[[Iterable], Iterable] = iter) -> "Clip":
        """The clip with its repeated frames marked, at the cost of a pass over the file. `progress` wraps that pass."""
        changes, regular, before = [], True, None
        for index, time, picture in progress(self._timed()):
            now = grey(picture[self.window])
            changes.append(0.0 if before is None else float(np.abs(now - before).mean()))
            regular = regular and time == index * 1000 / self.fps
            before = now
        return dataclasses.replace(self, repeats=find_repeats(np.array(changes)), regular=regular)

    def _timed(self) -> Iterator[tuple[int, float, Picture]]:
        """Index, time in ms and picture. The regular clock holds wherever the file's stamps do not speak against it."""
        last = -math.inf
        for index, (picture, stamp) in enumerate(self.pictures):
            if picture.shape[:2] != self.size:
                found, first = _text(picture.shape), _text(self.size)
                raise ValueError(f"{self.name}: frame {index} has {found} pixels, the first {first}; use one size")
            time = index * 1000 / self.fps
            if not self.told and stamp is not None and abs(stamp - time) > _ROUNDING_MS:
                time = stamp if stamp > last else last + 1000 / self.fps
            last = time
            yield index, time, picture

    def _seen(self, picture: Picture) -> Float[np.ndarray, "height width"]:
        levels = grey(picture[self.window])
        if levels.shape == self.shape:
            return levels
        return resized(levels, self.shape, anti_aliasing=True, preserve_range=True).astype(np.float32)


def open_clip(
    path: str | os.PathLike,
    *,
    fps: float | int | None = None,
    crop: tuple[slice, slice] | None = None,
    resize: int | None = None,
) -> Clip:
    """A clip, ready to be read. Its first frame is read here, so that what is wrong shows before the work.

    **Arguments:**

    - `path`: any video that ffmpeg reads, or a folder of images (in natural order).
    - `fps`: frames per second, instead of what the file and its time stamps say; a folder needs it.
    - `crop`: the rows and columns to use, such as `np.s_[20:200, 36:397]`.
    - `resize`: width in pixels of what the model sees, after the crop; the height follows. Anti-aliased.

    **Raises:** `ValueError` for what is no clip and for options that do not fit it, `FileNotFoundError` for no file.
    """
    name = os.fspath(path)
    pictures = open_pictures(path)
    first = next(iter(pictures), None)
    if first is None:
        raise ValueError(f"{name} holds no frame that can be read")
    rows, cols = size = first[0].shape[:2]
    if fps is None and pictures.fps is None:
        raise ValueError(f"{name} states no frame rate; give it: fps = 30 (--fps 30)")
    rate = pictures.fps if fps is None else fps
    if rate is None or not (math.isfinite(rate) and rate > 0):
        raise ValueError(f"fps is {rate}; give a positive number of frames per second")
    window = crop or (slice(None), slice(None))
    height, width = (_length(part, edge) for part, edge in zip(window, size, strict=True))
    if not (height and width):
        asked = ",".join(f"{'' if s.start is None else s.start}:{'' if s.stop is None else s.stop}" for s in window)
        raise ValueError(f"crop {asked} does not lie in the frame; its rows are 0:{rows}, its columns 0:{cols}")
    shape = (height, width) if resize is None else (round(height * resize / width), resize)
    if min(shape) < 3:
        raise ValueError(f"{name} is {_text(shape)} pixels after crop and resize; the network needs at least 3 x 3")
    return Clip(name, pictures, float(rate), fps is not None, size, window, shape)


def window_of(text: str) -> tuple[slice, slice]:
    """The rows and columns that `TOP:BOTTOM,LEFT:RIGHT` names.

    **Raises:** `ValueError` for another text.
    """
    match = re.fullmatch(r"(\d*):(\d*),(\d*):(\d*)", text.replace(" ", ""))
    if match is None:
        raise ValueError(f"crop is {text!r}; write TOP:BOTTOM,LEFT:RIGHT in pixels, such as 20:200,36:397 or :,36:397")
    top, bottom, left, right = (int(edge) if edge else None for edge in match.groups())
    return slice(top, bottom), slice(left, right)


def grey(picture: Picture) -> Float[np.ndarray, "row col"]:
    """Grey levels 0..255 by ITU-R 601: .299 R + .587 G + .114 B."""
    red, green, blue = np.moveaxis(picture.astype(np.float32), -1, 0)
    return np.float32(0.299) * red + np.float32(0.587) * green + np.float32(0.114) * blue


def _length(part: slice, edge: int) -> int:
    """How many pixels a slice takes of an edge; 0 where it reaches beyond it."""
    start, stop = part.start or 0, edge if part.stop is None else part.stop
    return stop - start if 0 <= start < stop <= edge else 0


def _text(shape: tuple[int, ...]) -> str:
    return f"{shape[0]} x {shape[1]}"
