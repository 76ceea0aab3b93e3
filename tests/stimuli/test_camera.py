"""The camera: noise, flicker, blur and bits, one at a time."""

import dataclasses

import jax
import numpy as np
import pytest
from skimage.filters import gaussian

from lgmd2jax import Eye, stimuli

EYE = Eye(rows=24, cols=30, degrees_per_pixel=2.0, fps=100.0)
KEY = jax.random.key(1)
OFF = {"noise": 0, "bits": None}


@pytest.fixture(scope="module")
def stimulus():
    return stimuli.looming(EYE, start_ms=-300, end_ms=100)


def test_camera_without_faults_changes_nothing(stimulus):
    film = stimuli.camera(stimulus, KEY, **OFF)
    assert np.allclose(film.frames, stimulus.frames)
    assert np.array_equal(film.time, stimulus.time)
    assert film.name == stimulus.name


def test_noise_has_its_strength_and_is_new_in_every_frame(stimulus):
    noise = np.asarray(stimuli.camera(stimulus, KEY, noise=3, bits=None).frames - stimulus.frames)
    assert noise.std() == pytest.approx(3, rel=0.03)
    assert abs(noise.mean()) < 0.1
    assert abs((noise[1:] * noise[:-1]).mean()) < 0.2


def test_the_same_key_is_the_same_noise(stimulus):
    again = [stimuli.camera(stimulus, jax.random.key(seed)).frames for seed in (1, 1, 2)]
    assert np.array_equal(again[0], again[1])
    assert not np.array_equal(again[0], again[2])


def test_flicker_beats_with_the_frame_rate(stimulus):
    gain = np.asarray(stimuli.camera(stimulus, KEY, flicker=0.1, flicker_hz=110, **OFF).frames / stimulus.frames)
    assert np.allclose(gain, gain[:, :1, :1])
    wave = gain[:40, 0, 0] - 1
    spectrum = np.abs(np.fft.rfft(wave)) / 20
    assert spectrum.argmax() == 4
    assert spectrum.max() == pytest.approx(0.1)


def test_blur_is_a_gaussian(stimulus):
    blurred = np.asarray(stimuli.camera(stimulus, KEY, blur=1.3, **OFF).frames[30])
    expected = gaussian(np.asarray(stimulus.frames[30]), sigma=1.3, mode="nearest", truncate=8, preserve_range=True)
    assert np.max(np.abs(blurred - expected)) < 1e-3


@pytest.mark.parametrize("bits", [1, 4, 8])
def test_bits_leave_so_many_levels(stimulus, bits):
    film = np.asarray(stimuli.camera(stimulus, KEY, noise=20, bits=bits).frames)
    step = 255 / (2**bits - 1)
    assert np.allclose(film / step, np.rint(film / step))
    assert film.min() >= 0
    assert film.max() <= 255


def test_slopes_pass_the_rounding(stimulus):
    def pixel(change, bits):
        louder = dataclasses.replace(stimulus, frames=change["gain"] * stimulus.frames)
        return stimuli.camera(louder, KEY, noise=0, blur=change["blur"], bits=bits).frames[20, 12, 8]

    slopes = jax.jit(jax.grad(pixel), static_argnums=1)
    point = {"gain": 1.0, "blur": 1.0}
    rounded, analogue = slopes(point, 8), slopes(point, None)
    for name in point:
        step = 1e-5
        difference = pixel(point | {name: 1 + step}, None) - pixel(point | {name: 1 - step}, None)
        assert float(analogue[name]) == pytest.approx(float(difference / (2 * step)), rel=1e-6)
        assert float(rounded[name]) == pytest.approx(float(analogue[name]))
    assert np.isfinite(slopes({"gain": 1.0, "blur": 0.0}, 8)["blur"])
