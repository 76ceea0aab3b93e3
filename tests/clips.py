"""Small clips for tests, as float64 grey levels of (time, row, col)."""

import jax
import numpy as np

# Between a whole clip and the same frame by frame: since JAX 0.12 both may add the pixels of float32 in another order.
ROUNDING = 0.0 if jax.__version_info__ < (0, 12) else 2.0**-22


def noise(seed: int, shape: tuple[int, int, int], integer: bool = False) -> np.ndarray:
    """Grey levels without any structure, away from the ends of their range."""
    values = np.random.default_rng(seed).uniform(10, 245, shape)
    return np.round(values) if integer else values


def loom(seed: int = 0, shape: tuple[int, int, int] = (24, 15, 17), dark: bool = True) -> np.ndarray:
    """A square that grows ever faster, stands, and is textured, on a textured ground."""
    time, rows, cols = shape
    generator = np.random.default_rng(seed)
    ground, texture = generator.uniform(180, 220, (rows, cols)), generator.uniform(10, 40, (rows, cols))
    frames = np.repeat(ground[None], time, axis=0)
    x, y = np.mgrid[:rows, :cols]
    distance = np.maximum(np.abs(x - rows // 2), np.abs(y - cols // 2))
    grows = int(0.6 * time)
    for t in range(4, time):
        radius = 9.0 / (grows - min(t, grows) + 1.5) if t > 3 else 0
        frames[t] = np.where(distance <= radius, texture, ground)
    return frames if dark else 255 - frames


def patchy(seed: int, shape: tuple[int, int, int]) -> np.ndarray:
    """In each frame some pixels, or many, take another grey level; the others stay."""
    generator = np.random.default_rng(seed)
    frames = np.repeat(generator.uniform(60, 190, (1, *shape[1:])), shape[0], axis=0)
    for t in range(1, shape[0]):
        changes = generator.random(shape[1:]) < generator.choice([0.05, 0.3])
        frames[t] = np.where(changes, generator.uniform(10, 245, shape[1:]), frames[t - 1])
    return frames
