"""Surroundings by chance: plain walls and pieces of photographs, as a camera that moves or stands sees them."""

import numpy as np
from jaxtyping import Float

from lgmd2jax.stimuli import _texture as texture
from lgmd2jax.stimuli._background import Photograph

_PIECE = 240, 320  # texels; one size and the photograph's place in it by chance: shapes would compile anew
_PLAIN = 0.3  # share of surroundings without any texture
_STILL = 0.5  # share of photographs that stand
_DRIFT = 8.0  # deg/s, the fastest behind an object
_CONTRAST = 0.1, 0.5  # of a photograph: standard deviation by mean


def surroundings(chance: np.random.Generator, levels: tuple[float, float]) -> float | Photograph:
    """What an object is seen against: a grey level in a range, or a photograph of such a mean, half of which drift."""
    if chance.random() < _PLAIN:
        return chance.uniform(*levels)
    speed = 0.0 if chance.random() < _STILL else chance.uniform(0, _DRIFT)
    return Photograph(piece(chance, levels), speed=speed, direction=chance.uniform(0, 360))


def piece(chance: np.random.Generator, levels: tuple[float, float]) -> Float[np.ndarray, "height width"]:
    """A piece of a photograph, perhaps mirrored, at a mean level and a contrast; what leaves 0..255 saturates."""
    whole = np.asarray(texture.read(str(chance.choice(list(texture.PHOTOGRAPHS)))))
    top, left = (chance.integers(size - part + 1) for size, part in zip(whole.shape, _PIECE, strict=True))
    part = whole[top : top + _PIECE[0], left : left + _PIECE[1]]
    if chance.random() < 0.5:
        part = part[:, ::-1]
    deviation = (part - part.mean()) / max(part.std(), 1.0)
    return np.clip(chance.uniform(*levels) * (1 + chance.uniform(*_CONTRAST) * deviation), 0, 255)
