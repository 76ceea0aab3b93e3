"""The eye: how the world is sampled into frames."""

import dataclasses
import math
from typing import Literal


@dataclasses.dataclass(frozen=True)
class Eye:
    """The sampling that a stimulus is rendered for and that a parameter set belongs to.

    **Arguments:**

    - `rows`, `cols`: size of a frame in pixels, at least 3 each.
    - `degrees_per_pixel`: visual angle of one pixel, in degrees (of the central one under a pinhole projection).
    - `fps`: frames per second.
    - `projection`: `"equidistant"` (a pixel is `degrees_per_pixel` everywhere) or `"pinhole"` (a camera or a screen).

    **Raises:** `ValueError` for a size below 3 x 3 and for non-positive or non-finite numbers.
    """

    rows: int
    cols: int
    degrees_per_pixel: float
    fps: float
    projection: Literal["equidistant", "pinhole"] = "equidistant"

    def __post_init__(self):
        for name in ("rows", "cols"):
            size = getattr(self, name)
            if not isinstance(size, int) or size < 3:
                raise ValueError(f"{name} is {size!r}; an eye has a whole number of at least 3 {name}")
        for name, unit in (("degrees_per_pixel", "degrees"), ("fps", "frames per second")):
            number = getattr(self, name)
            if not (math.isfinite(number) and number > 0):
                raise ValueError(f"{name} is {number!r}; give a positive number of {unit}")
        if self.projection not in ("equidistant", "pinhole"):
            raise ValueError(f"projection is {self.projection!r}; choose 'equidistant' or 'pinhole'")
