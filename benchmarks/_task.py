"""What every subject of the benchmark computes: the response of one network to the same noisy approach."""

import dataclasses
from typing import NamedTuple

import numpy as np
from jaxtyping import UInt8

import lgmd2jax as lgmd

FPS = 30.0


class Size(NamedTuple):
    """Of a frame, in pixels."""

    rows: int
    cols: int

    def __str__(self):
        return f"{self.rows}x{self.cols}"


LARGE, ROBOT, SMALL = Size(240, 320), Size(72, 99), Size(48, 64)

_DEFAULTS = {field.name: field.default for field in dataclasses.fields(lgmd.Parameters)}
# Each term of the network counts, and the film below passes every threshold in both directions.
_CHANGED = {"theta1": 0.4, "theta2": 1.3, "theta3": 0.02, "T_s": 15.0, "T_ffi": 12.0, "k": 4.0}
PARAMETERS: dict[str, float] = {**_DEFAULTS, **_CHANGED}
# The same in single precision, by attribute.
Values = NamedTuple("Values", [(name, np.float32) for name in PARAMETERS])
VALUES = Values(*map(np.float32, PARAMETERS.values()))


def film(size: Size, time: int, seed: int = 0) -> UInt8[np.ndarray, "time row col"]:
    """A dark disc that grows over textured ground, as a camera delivers it, every pixel with its noise.

    Without noise the maps of pixels at rest decay to denormal numbers, and their slowness would be what is measured.
    """
    random = np.random.default_rng(seed)
    y, x = np.mgrid[: size.rows, : size.cols]
    distance = np.hypot(y - size.rows / 2, x - size.cols / 2)
    radius = 0.1 * size.rows / (1.1 - np.arange(time) / time)
    ground, disc = random.uniform(150, 230, size), random.uniform(10, 40, size)
    frames = np.where(distance < radius[:, None, None], disc, ground) + random.normal(0, 2, (time, *size))
    return np.round(np.clip(frames, 0, 255)).astype(np.uint8)
