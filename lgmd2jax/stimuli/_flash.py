"""Sudden changes of the light on all that is seen: lamps that pass at night, the sun between trees, a lorry's shade."""

import numpy as np
from jaxtyping import Float

from lgmd2jax.stimuli._shot import Shot

_SEEN = 0.3  # of the films
_MOST = 3  # in a film
_EDGE = 0.03  # s, in which the light comes and goes


def flashed(light: Float[np.ndarray, "time row col"], shot: Shot) -> Float[np.ndarray, "time row col"]:
    """The light, which in some films becomes brighter or darker for a moment, more so on one side."""
    if not shot.often(_SEEN):
        return light
    course = np.zeros_like(shot.time)
    for _ in range(int(shot.chance.integers(1, _MOST + 1))):
        since, lasts = shot.time - shot.between(0, shot.lasts), shot.log(0.06, 0.6)
        change = shot.log(0.01, 0.3) * shot.side()
        course += change * (np.clip(since / _EDGE, 0, 1) - np.clip((since - lasts) / _EDGE, 0, 1))
    less, cols = shot.between(0, 0.9), np.linspace(0, 1, light.shape[2])
    share = 1 - less * (cols if shot.often(0.5) else cols[::-1])
    return light * (1 + np.maximum(course, -0.8)[:, None, None] * share)
