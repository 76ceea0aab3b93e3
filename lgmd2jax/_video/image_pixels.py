"""The pixels of an image file, at the depth that they are stored at."""

import dataclasses
from collections.abc import Iterator

import numpy as np
from jaxtyping import Shaped

from lgmd2jax._video.grey import Grey, Picture, area_average, grey
from lgmd2jax._video.orientation import Window


@dataclasses.dataclass(frozen=True)
class ImagePixels:
    """Values of grey or of red, green and blue, from 0 for black to `white`. `remarks`: what a user should know."""

    values: Shaped[np.ndarray, "row col *channel"]
    white: float
    remarks: tuple[str, ...] = ()

    @property
    def size(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, cols = self.values.shape[:2]
        return rows, cols

    @property
    def aspect(self) -> float:
        """How much wider than high a pixel is."""
        return 1.0

    def picture(self) -> Picture:
        """The whole picture in 8 bits."""
        if self.values.dtype == np.uint8 and self.white == 255:
            return _coloured(self.values)
        return np.round(_coloured(self._levels(self.values))).astype(np.uint8)

    def grey(self, window: Window, shape: tuple[int, int]) -> Grey:
        """Grey levels 0..255 of a window, averaged to a shape."""
        return area_average(grey(_coloured(self._levels(self.values[window]))), shape)

    def _levels(self, values: np.ndarray) -> np.ndarray:
        return values.astype(np.float32) * np.float32(255 / self.white)


def remarks_on_depth(brightest: float | int, full: float | int, told: float | int | None) -> Iterator[str]:
    """What to say of a picture of more than 8 bits that leaves the upper quarters of its range unused."""
    if told is None and full > 255 and 0 < brightest < full / 4:
        bits = next(bits for bits in (8, 10, 12, 14, 16) if brightest < 2**bits)
        yield (
            f"its brightest pixel is {brightest:g} of {full:g}; "
            f"if the camera gives {bits} bits, give it: white = {2**bits - 1} (--white {2**bits - 1})"
        )


def _coloured(values: np.ndarray) -> np.ndarray:
    return values if values.ndim == 3 else np.broadcast_to(values[..., None], (*values.shape, 3))
