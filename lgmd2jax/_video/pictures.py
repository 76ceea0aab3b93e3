"""What a path holds: a video, a folder of images, or an image file of several pages."""

import os
from pathlib import Path

from lgmd2jax._video.image_file import TIFF
from lgmd2jax._video.image_folder import ImageFolder
from lgmd2jax._video.image_pixels import ImagePixels
from lgmd2jax._video.video_file import VideoFile
from lgmd2jax._video.video_pixels import VideoPixels

Pictures = VideoFile | ImageFolder
Pixels = VideoPixels | ImagePixels
_STACKS = (*TIFF, ".webp")  # files of pages that ffmpeg does not read, or one page of them


def open_pictures(path: str | os.PathLike, *, white: float | int | None = None, until_damage: bool = False) -> Pictures:
    """The pictures of a video file, of a folder of images, or of the pages of a TIFF or WebP file.

    **Arguments:** as for `open_clip`.

    **Raises:** `FileNotFoundError` for a path that is not there, `ValueError` for one that holds no pictures.
    """
    path = Path(path)
    if path.is_dir():
        return ImageFolder.of(path, white)
    if path.is_file():
        return ImageFolder([path], white) if path.suffix.lower() in _STACKS else VideoFile(path, white, until_damage)
    raise FileNotFoundError(f"no such clip: {path}; give a video file or a folder of images")
