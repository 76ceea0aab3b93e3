"""Clips are drawn in pieces of one length, so that clips of any length share the program that draws them."""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from lgmd2jax._eye import Eye
from lgmd2jax._types import is_concrete

_FRAMES = 64  # of a piece, at most
_PIXELS = 2**20  # of a piece of large frames


def in_pieces(draw: Callable[..., Any], eye: Eye, moments: Any, *lasting: Any) -> Any:
    """What `draw(eye, moments, *lasting)` returns. Leaves of `moments` and of the result have time as their first axis.

    `draw` looks at each moment by itself; a last piece that is too short is filled up with the last moment. What is
    traced is drawn as a whole.
    """
    if not is_concrete(*filter(eqx.is_array, jax.tree.leaves((moments, lasting)))):
        return draw(eye, moments, *lasting)
    arrays = jax.tree.map(np.asarray, moments)
    count, length = len(jax.tree.leaves(arrays)[0]), min(max(_PIXELS // (eye.rows * eye.cols), 1), _FRAMES)
    pieces = []
    for first in range(0, count, length):
        frames = np.minimum(np.arange(first, first + length), count - 1)
        pieces.append(draw(eye, jax.tree.map(lambda leaf, frames=frames: leaf[frames], arrays), *lasting))
    return jax.tree.map(lambda *parts: jnp.asarray(np.concatenate(parts)[:count]), *pieces)
