"""A folder of images, or one file of several pages, as the frames of a clip."""

import itertools
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from lgmd2jax._video.image_file import PAGED, SUFFIXES, read_image
from lgmd2jax._video.image_pixels import ImagePixels


class ImageFolder:
    """Images in natural order: 2.png before 10.png. What is no image, is hidden or is empty is passed over.

    Pages count as images. `fps` is None: images state no frame rate. `remarks`: what a user should know. Iteration
    gives the pixels of each image, with None for a time stamp.
    """

    fps: float | None = None

    def __init__(self, paths: Sequence[Path], white: float | int | None = None):
        self._white = white
        self.paths, self.remarks = _in_order(paths)
        multiple = any(path.suffix.lower() in PAGED for path in self.paths) and self._pages(self.paths[0]) > 1
        self.count = None if multiple else len(self.paths)

    @classmethod
    def of(cls, folder: Path, white: float | int | None = None) -> "ImageFolder":
        """The images of a folder.

        **Raises:** `ValueError` for a folder without images.
        """
        images = [path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES and path.name[0] != "."]
        if not images:
            raise ValueError(f"{folder} holds no image; give a video file or a folder of {', '.join(SUFFIXES)}")
        return cls(images, white)

    def __iter__(self) -> Iterator[tuple[ImagePixels, None]]:
        for path in self.paths:
            for pixels in read_image(path, self._white):
                yield pixels, None

    def _pages(self, path: Path) -> int:
        return sum(1 for _ in zip(range(2), read_image(path, self._white), strict=False))


def _in_order(images: Sequence[Path]) -> tuple[list[Path], tuple[str, ...]]:
    """The images that hold something, by the numbers in their names, and what is odd about these."""
    remarks = []
    paths = [path for path in images if path.stat().st_size]
    if not paths:
        raise ValueError(f"{images[0].parent} holds empty images alone; give images with content")
    if len(paths) < len(images):
        empty = min(path.name for path in images if path not in paths)
        remarks.append(
            f"{len(images) - len(paths)} images are empty (0 bytes), the first {empty}; they are passed over, "
            "and the frames beside them are taken for neighbours"
        )
    below_zero = _signed([path.stem for path in paths])
    paths.sort(key=lambda path: _natural(path, below_zero))
    if below_zero:
        remarks.append(f"the images run from {paths[0].name} to {paths[-1].name}: a hyphen before a number is a minus")
    return paths, (*remarks, *_gaps(paths, below_zero))


def _signed(stems: Sequence[str]) -> bool:
    """Whether hyphens are signs: they begin a name, or the same name comes with and without one before its number."""
    starts = {match[1] for stem in stems if (match := re.match(r"(\D*)[0-9]", stem))}
    return any(start == "-" or (start.endswith("-") and start[:-1] in starts) for start in starts)


def _natural(path: Path, below_zero: bool) -> list:
    """The name with numbers as numbers, at odd places."""
    parts = re.split(r"(-?[0-9]+)" if below_zero else r"([0-9]+)", path.stem.lower())
    return [*(int(part) if place % 2 else part for place, part in enumerate(parts)), path.suffix.lower()]


def _gaps(paths: Sequence[Path], below_zero: bool) -> Iterator[str]:
    """What to say where the one number that counts the images is not evenly spaced."""
    numbers = [_natural(path, below_zero)[1:-1:2] for path in paths]
    counters = [column for column in zip(*numbers, strict=False) if len(set(column)) > 1]
    if len(counters) != 1 or len({len(row) for row in numbers}) > 1:
        return
    steps = [after - before for before, after in itertools.pairwise(counters[0])]
    usual = max(set(steps), key=steps.count)
    odd = next((place for place, step in enumerate(steps) if step != usual), None)
    if odd is not None:
        yield (
            f"the numbers of the images are not evenly spaced, first between {paths[odd].name} and "
            f"{paths[odd + 1].name}; frames are taken at equal intervals all the same"
        )
