"""Small things that move in their place, in a part of the field: leaves, water, a crowd."""

import numpy as np
from jaxtyping import Float

from lgmd2jax.stimuli._shot import Shot, swings

_SEEN = 0.5  # of the films
_PATCH = 2  # rays in each direction that go to and fro together: a pixel of the eye
_SWINGS = 3


def fluttered(light: Float[np.ndarray, "time row col"], shot: Shot) -> Float[np.ndarray, "time row col"]:
    """The light on the finer raster of `draw`, some of it restless.

    **Arguments:** `light`: with even rows and columns.
    """
    if not shot.often(_SEEN):
        return light
    rows, cols = (size // _PATCH for size in light.shape[1:])
    size, rates = shot.log(0.03, 0.3), [shot.log(0.3, 4) for _ in range(_SWINGS)]
    phases = np.random.default_rng(shot.chance.integers(2**32)).random((_SWINGS, rows, cols))
    off = np.hypot(
        (np.linspace(0, 1, rows)[:, None] - shot.between(0, 1)) / shot.log(0.1, 0.6),
        (np.linspace(0, 1, cols) - shot.between(0, 1)) / shot.log(0.1, 0.6),
    )
    moving = size * np.clip(2 - 2 * off, 0, 1)
    restless = moving * np.sqrt(2 / _SWINGS) * swings(shot.time[:, None, None], rates, phases)
    return light * (1 + restless.repeat(_PATCH, axis=1).repeat(_PATCH, axis=2))
