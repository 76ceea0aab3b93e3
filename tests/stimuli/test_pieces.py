"""Clips drawn in pieces: of any length by one program, with the frames of the whole."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.stimuli import _pieces
from lgmd2jax.stimuli._pieces import in_pieces

EYE = lgmd.Eye(9, 12, degrees_per_pixel=6.0, fps=50.0)
LARGE = lgmd.Eye(1000, 2000, degrees_per_pixel=0.05, fps=50.0)


@pytest.mark.parametrize("count", [1, 63, 64, 65, 200])
def test_clips_of_all_lengths_are_drawn_in_pieces_of_one(count):
    lengths = []

    def draw(eye, moments, factor):
        lengths.append(len(moments["at"]))
        return factor * moments["at"], moments["level"] ** 2

    at, level = jnp.arange(float(count)), np.linspace(0, 1, 3 * count).reshape(count, 3)
    frames, squares = in_pieces(draw, EYE, {"at": at, "level": level}, 2.0)
    np.testing.assert_array_equal(frames, 2 * np.arange(count))
    np.testing.assert_array_equal(squares, level**2)
    assert set(lengths) == {64}


def test_pieces_of_large_frames_are_short():
    lengths = []
    in_pieces(lambda eye, moments: lengths.append(len(moments)) or moments, LARGE, jnp.arange(3.0))
    assert lengths == [1, 1, 1]


@pytest.mark.parametrize("family", [lgmd.stimuli.looming, lgmd.stimuli.receding, lgmd.stimuli.approach_recession])
def test_a_traced_clip_is_the_one_that_is_drawn_in_pieces(family, monkeypatch):
    monkeypatch.setattr(_pieces, "_FRAMES", 7)

    def frames(contrast):
        return family(EYE, contrast=contrast, start_ms=-300.0, end_ms=400.0).frames

    np.testing.assert_allclose(frames(-0.5), jax.jit(frames)(-0.5), rtol=1e-12)
