"""Pictures from disk, one at a time: a video file through ffmpeg (PyAV), or a folder of images."""

import os
import re
from collections.abc import Iterator
from pathlib import Path

import imageio.v3 as iio
import numpy as np
from jaxtyping import UInt8
from skimage.util import img_as_ubyte

Picture = UInt8[np.ndarray, "row col 3"]

_IMAGES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".ppm", ".webp")


class ImageFolder:
    """The images of a folder in natural order: 2.png before 10.png. What is no image is passed over.

    `fps` is None: images state no frame rate. Iteration gives 8-bit RGB pictures, each with None for a time stamp.
    """

    fps: float | None = None

    def __init__(self, folder: Path):
        self.paths = sorted((path for path in folder.iterdir() if path.suffix.lower() in _IMAGES), key=_natural)
        self.count = len(self.paths)
        if not self.paths:
            raise ValueError(f"{folder} holds no image; give a video file or a folder of {', '.join(_IMAGES)}")

    def __iter__(self) -> Iterator[tuple[Picture, None]]:
        for path in self.paths:
            try:
                image = iio.imread(path, plugin="pillow", index=0, rotate=True)
            except (OSError, SyntaxError, ValueError) as error:
                raise ValueError(f"cannot read {path} as an image: {error}") from error
            yield _eight_bit_rgb(image), None


class VideoFile:
    """The first video stream of a file.

    `fps` is the frame rate that the file states and `count` the number of its frames, or None. Iteration gives 8-bit
    RGB pictures, each with its time stamp in ms after the first, or None.
    """

    def __init__(self, path: Path):
        self.path = path
        with self._opened() as container:
            stream = container.streams.video[0]
            rate = stream.average_rate or stream.guessed_rate
            self.fps = float(rate) if rate else None
            self.count = stream.frames or None
            # What the header promises; with sound, the duration of the file is not that of the video.
            promises = [stream.duration and stream.time_base and float(stream.duration * stream.time_base)]
            if len(container.streams) == 1:
                promises.append(container.duration and container.duration / 1e6)
            self.seconds = min((promise for promise in promises if promise), default=None)

    def __iter__(self) -> Iterator[tuple[Picture, float | None]]:
        from av.error import FFmpegError

        first = end = None
        with self._opened() as container:
            stream = container.streams.video[0]
            stream.thread_type = "AUTO"
            try:
                for frame in container.decode(stream):
                    stamp = None
                    if frame.time is not None:
                        first = frame.time if first is None else first
                        stamp = 1000 * (frame.time - first)
                        end = frame.time - first + float(frame.duration * (frame.time_base or 0))
                    # The display matrix of a camera held upright.
                    yield np.rot90(frame.to_ndarray(format="rgb24"), round(frame.rotation / 90)), stamp
            except FFmpegError as error:
                raise ValueError(f"{self.path} is damaged or truncated: {error.strerror}; {self._cure()}") from error
        if self.seconds and end is not None and self.fps and end < 0.98 * self.seconds - 3 / self.fps:
            raise ValueError(
                f"{self.path} is truncated: it announces {self.seconds:.3g} s, ends after {end:.3g} s; {self._cure()}"
            )

    def _cure(self) -> str:
        return f"to use what is whole, save it anew: ffmpeg -i {self.path.name} -c copy whole{self.path.suffix}"

    def _opened(self):
        try:
            import av
            from av.error import FFmpegError
        except ImportError:
            raise ValueError("reading video needs PyAV: pip install 'lgmd2jax[video]'") from None
        try:
            # The prefix keeps ffmpeg from taking a colon in the name for a protocol.
            container = av.open(f"file:{self.path}")
        except FFmpegError as error:
            raise ValueError(f"{self.path} is no video, or a truncated one: {error.strerror}") from error
        # ffmpeg draws plain text as the screen of a terminal ("tty").
        if not container.streams.video or container.format.name == "tty":
            container.close()
            raise ValueError(f"{self.path} holds no video; give a video file or a folder of images")
        return container


Pictures = VideoFile | ImageFolder


def open_pictures(path: str | os.PathLike) -> Pictures:
    """The pictures of a video file or of a folder of images.

    **Raises:** `FileNotFoundError` for a path that is not there, `ValueError` for one that holds no pictures.
    """
    path = Path(path)
    if path.is_dir():
        return ImageFolder(path)
    if path.is_file():
        return VideoFile(path)
    raise FileNotFoundError(f"no such clip: {path}; give a video file or a folder of images")


def _natural(path: Path) -> list:
    parts = re.split(r"([0-9]+)", path.name.lower())
    return [int(part) if place % 2 else part for place, part in enumerate(parts)]


def _eight_bit_rgb(image: np.ndarray) -> Picture:
    image = img_as_ubyte(image)
    if image.ndim == 2:
        image = image[..., None]
    colours = image[..., :3] if image.shape[-1] >= 3 else image[..., :1]
    return np.broadcast_to(colours, (*image.shape[:2], 3))
