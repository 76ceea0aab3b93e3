"""The eye: how the world is sampled into frames."""

import dataclasses
import math
from typing import Literal

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, ScalarLike

from lgmd2jax._arguments.checked import checked
from lgmd2jax._words import nearest, warn

PROJECTIONS = ("equidistant", "pinhole")
PRESETS = ("paper", "colias", "locust")
_EDGE = 89.0  # degrees; what is seen further from the axis lies outside of every flat image


@checked
@dataclasses.dataclass(frozen=True)
class Eye:
    """The sampling that a stimulus is rendered for and that a parameter set belongs to.

    ```python
    Eye(rows=48, cols=64, degrees_per_pixel=2.0, fps=100.0)
    Eye.from_field_of_view(72, 99, 70.0, fps=30.0, projection="pinhole")    # 70 degrees wide
    Eye(rows=240, cols=320, degrees_per_pixel=None, fps=30.0)               # a screen, in pixels alone
    Eye.preset("locust")
    ```

    **Arguments:**

    - `rows`, `cols`: size of a frame in pixels, at least 3 each.
    - `degrees_per_pixel`: visual angle of one pixel, in degrees (of the central one under a pinhole projection). None
      for a screen that is known in pixels alone: what is asked for in degrees is then refused.
    - `fps`: frames per second.
    - `projection`: `"equidistant"` (a pixel is `degrees_per_pixel` everywhere) or `"pinhole"` (a camera or a screen).

    **Raises:** `ValueError` for a size below 3 x 3 and for non-positive or non-finite numbers.
    """

    rows: int
    cols: int
    degrees_per_pixel: float | int | None
    fps: float | int
    projection: Literal["equidistant", "pinhole"] = "equidistant"

    def __post_init__(self):
        for name in ("rows", "cols", "degrees_per_pixel", "fps"):
            if isinstance(number := getattr(self, name), np.generic):  # of a table, say
                object.__setattr__(self, name, number.item())
        for name in ("rows", "cols"):
            size = getattr(self, name)
            if not isinstance(size, int) or isinstance(size, bool) or size < 3:
                raise ValueError(f"{name} is {size!r}; an eye has a whole number of at least 3 {name}")
        for name, unit in (("degrees_per_pixel", "degrees"), ("fps", "frames per second")):
            number = getattr(self, name)
            if name == "degrees_per_pixel" and number is None:
                continue
            if not (isinstance(number, (int, float)) and math.isfinite(number) and number > 0):
                raise ValueError(f"{name} is {number!r}; give a positive number of {unit}")
        if self.fps < 1:
            warn(f"fps is {self.fps:.4g}; were {1 / self.fps:.4g} frames per second meant, given as an interval in s?")

    @classmethod
    @checked
    def from_field_of_view(
        cls,
        rows: int,
        cols: int,
        degrees: float | int,
        fps: float | int,
        projection: Literal["equidistant", "pinhole"] = "equidistant",
    ) -> "Eye":
        """An eye that sees `degrees` from its left to its right border.

        **Raises:** `ValueError` as for `Eye`, and for a pinhole of 180 degrees or more.
        """
        if not (math.isfinite(degrees) and degrees > 0):
            raise ValueError(f"degrees is {degrees!r}; give a positive field of view in degrees")
        if projection == "equidistant":
            return cls(rows, cols, degrees / cols, fps, projection)
        if degrees >= 180:
            raise ValueError(f"degrees is {degrees:g}; a pinhole sees less than 180; choose 'equidistant', or fewer")
        focal = cols / 2 / math.tan(math.radians(degrees) / 2)
        return cls(rows, cols, math.degrees(2 * math.atan(0.5 / focal)), fps, projection)

    @classmethod
    @checked
    def preset(cls, name: str) -> "Eye":
        """One of the eyes that the literature uses; `dataclasses.replace(eye, fps=200.0)` changes a field.

        - `"paper"`: the screen of Fu, Hu & Yue's synthetic stimuli, 240 rows x 320 columns, in pixels alone.
        - `"colias"`: their robot's camera, 72 x 99 at 30 fps, 70 degrees wide, pinhole.
        - `"locust"`: 48 x 64 at 2 degrees a pixel and 100 fps, 128 degrees wide.

        **Raises:** `ValueError` for another name.
        """
        if name not in PRESETS:
            raise ValueError(f"eye is {name!r}; choose {nearest(name, PRESETS)}")
        if name == "paper":
            return cls(240, 320, None, 30.0)
        if name == "colias":
            return cls.from_field_of_view(72, 99, 70.0, 30.0, "pinhole")
        return cls(48, 64, 2.0, 100.0)

    @property
    def pixels_per_degree(self) -> float:
        """Pixels to the degree, in the middle of the field."""
        return 1 / self._degrees_per_pixel

    @property
    def focal_px(self) -> float:
        """Distance of the image plane from the pinhole, in pixels."""
        return 0.5 / math.tan(math.radians(self._degrees_per_pixel) / 2)

    @property
    def field_of_view(self) -> tuple[float, float]:
        """Height and width of what is seen, in degrees, along the two middle lines."""
        if self.projection == "equidistant":
            return self.rows * self._degrees_per_pixel, self.cols * self._degrees_per_pixel
        height, width = (2 * math.degrees(math.atan(size / 2 / self.focal_px)) for size in (self.rows, self.cols))
        return height, width

    @property
    def field_area(self) -> float:
        """What is seen, in square degrees, each pixel as large as the central one.

        So an object in the middle of the field, of an angular size, takes the same share of the pixels in each
        projection.

        **Raises:** `ValueError` for an eye that is known in pixels alone.
        """
        return self.rows * self.cols * self._degrees_per_pixel**2

    @checked
    def project(self, degrees: ScalarLike | Float[Array, " time"]) -> Array:
        """Distance from the image's centre, in pixels, of what is seen `degrees` off the axis.

        **Raises:** `ValueError` for an eye that is known in pixels alone.
        """
        if self.projection == "equidistant":
            return jnp.asarray(degrees, dtype=float) / self._degrees_per_pixel
        return self.focal_px * jnp.tan(jnp.radians(jnp.clip(degrees, -_EDGE, _EDGE)))

    def pixel_centres(self) -> tuple[Float[np.ndarray, "row col"], Float[np.ndarray, "row col"]]:
        """Pixel centres to the right of and above the image's centre, in pixels."""
        x = np.arange(self.cols) - (self.cols - 1) / 2
        y = (self.rows - 1) / 2 - np.arange(self.rows)
        right, up = np.meshgrid(x, y)
        return right, up

    def angles(self) -> tuple[Float[np.ndarray, "row col"], Float[np.ndarray, "row col"]]:
        """Azimuth (right positive) and elevation (up positive) of the pixel centres, in degrees.

        **Raises:** `ValueError` for an eye that is known in pixels alone.
        """
        right, up = self.pixel_centres()
        if self.projection == "equidistant":
            return right * self._degrees_per_pixel, up * self._degrees_per_pixel
        azimuth = np.arctan2(right, self.focal_px)
        elevation = np.arctan2(up, np.hypot(right, self.focal_px))
        return np.degrees(azimuth), np.degrees(elevation)

    @property
    def _degrees_per_pixel(self) -> float:
        if self.degrees_per_pixel is None:
            raise ValueError("the eye has no degrees_per_pixel; give lengths as *_px, or an Eye with degrees_per_pixel")
        return self.degrees_per_pixel
