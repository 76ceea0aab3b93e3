"""How a camera was held: the turn and the mirror between a picture as it is stored and as it is shown."""

import dataclasses
from collections.abc import Sequence

import numpy as np

Window = tuple[slice, slice]


@dataclasses.dataclass(frozen=True)
class Orientation:
    """The shown picture is the stored one: transposed first, then flipped top to bottom and left to right."""

    transposed: bool = False
    flipped_rows: bool = False
    flipped_cols: bool = False

    @classmethod
    def of_exif(cls, number: int) -> "Orientation":
        """By the EXIF (and TIFF) tag 274; a number that the standard does not know turns nothing."""
        return _BY_EXIF.get(number, cls())

    @classmethod
    def of_matrix(cls, matrix: Sequence[int]) -> "Orientation":
        """By the display matrix of a video, (a b u, c d v, x y w): x' = a x + c y, y' = b x + d y.

        **Raises:** `ValueError` for a turn by another angle than quarters.
        """
        a, b, _, c, d = matrix[:5]
        if b == c == 0:
            return cls(False, d < 0, a < 0)
        if a == d == 0:
            return cls(True, b < 0, c < 0)
        raise ValueError("is to be shown at an angle that is no multiple of 90 degrees; turn it first, with ffmpeg")

    def shown(self, stored: np.ndarray) -> np.ndarray:
        """The picture as it is shown, from the stored one: (row, col) or (row, col, channel)."""
        turned = stored.swapaxes(0, 1) if self.transposed else stored
        return turned[:: -1 if self.flipped_rows else 1, :: -1 if self.flipped_cols else 1]

    def shape(self, shape: tuple[int, int]) -> tuple[int, int]:
        """Rows and columns as shown from those stored, and the other way round."""
        return (shape[1], shape[0]) if self.transposed else shape

    def stored(self, window: Window, shape: tuple[int, int]) -> Window:
        """The window of the stored picture that becomes this window of the shown one, whose shape is given."""
        flips = (self.flipped_rows, self.flipped_cols)
        rows, cols = (_mirrored(*its) for its in zip(window, shape, flips, strict=True))
        return (cols, rows) if self.transposed else (rows, cols)


def _mirrored(part: slice, length: int, flipped: bool) -> slice:
    start, stop, _ = part.indices(length)
    return slice(length - stop, length - start) if flipped else slice(start, stop)


_BY_EXIF = {
    2: Orientation(flipped_cols=True),
    3: Orientation(flipped_rows=True, flipped_cols=True),
    4: Orientation(flipped_rows=True),
    5: Orientation(transposed=True),
    6: Orientation(transposed=True, flipped_cols=True),
    7: Orientation(transposed=True, flipped_rows=True, flipped_cols=True),
    8: Orientation(transposed=True, flipped_rows=True),
}
