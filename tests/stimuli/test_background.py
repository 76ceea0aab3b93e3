"""Photographs behind objects: against scikit-image's resizing and warping."""

import socket

import jax.numpy as jnp
import numpy as np
import pytest
from skimage.io import imsave
from skimage.transform import AffineTransform, resize, warp

from lgmd2jax import Eye, stimuli
from lgmd2jax.stimuli._scene import film

EYE = Eye(rows=32, cols=40, degrees_per_pixel=1.0, fps=100.0)
PINHOLE = Eye(rows=32, cols=40, degrees_per_pixel=1.0, fps=100.0, projection="pinhole")
TIME = jnp.arange(8) * 10.0
SMOOTH = 110 + 50 * np.sin(np.arange(160) / 12)[:, None] * np.cos(np.arange(200) / 15)[None, :]


def frames_of(background, eye=EYE):
    """A background alone."""
    return np.array(film(eye, TIME, background))


@pytest.mark.parametrize("name", stimuli.PHOTOGRAPHS)
def test_every_photograph_comes_with_the_wheel(name, monkeypatch):
    def refuse(*_):
        raise AssertionError("a photograph was to be downloaded")

    monkeypatch.setattr(socket.socket, "connect", refuse)
    image = np.asarray(stimuli.Photograph(name).image)
    assert image.ndim == 2
    assert image.min() >= 0
    assert image.max() <= 255
    assert image.std() > 5


def test_photograph_is_what_scikit_image_resizes():
    photograph = stimuli.Photograph("camera")
    frame = frames_of(photograph)[0]
    whole = np.asarray(resize(np.asarray(photograph.image), (40, 40), anti_aliasing=True))[4:36]
    assert np.corrcoef(frame.ravel(), whole.ravel())[0, 1] > 0.99
    assert frame.mean() == pytest.approx(whole.mean(), rel=0.01)


def test_level_and_contrast_of_a_photograph_come_out_as_asked():
    photograph = stimuli.Photograph(SMOOTH, level=90, contrast=0.5)
    assert photograph.mean_level == pytest.approx(90)
    own, changed = frames_of(stimuli.Photograph(SMOOTH))[0], frames_of(photograph)[0]
    assert np.allclose(changed / 90 - 1, 0.5 * (own / SMOOTH.mean() - 1))
    stimulus = stimuli.looming(EYE, background=photograph, contrast=-0.5, stop_angle=20, start_ms=-50, end_ms=50)
    assert stimulus.frames[-1, 16, 20] == pytest.approx(45)


@pytest.mark.parametrize("direction", [0.0, 90.0, 217.0])
def test_photograph_drifts_at_its_speed_between_pixels(direction):
    frames = frames_of(stimuli.Photograph(SMOOTH, speed=33, direction=direction))
    heading = np.radians(direction)
    for i in (1, 7):
        path = 33 * i / 100
        shift = AffineTransform(translation=(-path * np.cos(heading), path * np.sin(heading)))
        expected = warp(frames[0], shift, order=3, mode="edge", preserve_range=True)
        assert np.max(np.abs(frames[i] - expected)[4:-4, 4:-4]) < 0.6


def test_photograph_goes_on_in_mirror_image_beyond_its_border():
    frame = frames_of(stimuli.Photograph(SMOOTH, width=20.0))[0]
    assert np.allclose(frame[:, :10], frame[:, 19:9:-1], atol=1e-6)
    assert np.allclose(frame[:8], frame[15:7:-1], atol=1e-6)


@pytest.mark.parametrize("direction", ["right", "left"])
def test_scene_passes_to_the_other_side_than_the_eye_turns_to(direction):
    scene = stimuli.Panorama(SMOOTH, width=80.0)
    stimulus = stimuli.turning(
        EYE, background=scene, speed=100, direction=direction, duration_ms=100, start_ms=-50, end_ms=200
    )
    frames, time = np.asarray(stimulus.frames), np.asarray(stimulus.time)
    first, last = frames[0], frames[-1]
    assert np.all(frames[time <= 0] == first)
    assert np.all(frames[time >= 100] == last)
    if direction == "right":
        assert np.allclose(last[:, :-10], first[:, 10:], atol=1e-6)
    else:
        assert np.allclose(last[:, 10:], first[:, :-10], atol=1e-6)


def test_panorama_through_a_pinhole_is_the_globe_at_the_pixels_angles():
    scene = stimuli.Panorama(SMOOTH, width=50.0)
    azimuth, elevation = PINHOLE.angles()
    across, up = azimuth / 50 * 200 + 99.5, 79.5 - elevation / 50 * 200
    expected = warp(SMOOTH, np.array([up, across]), order=1, mode="edge")
    assert np.max(np.abs(frames_of(scene, PINHOLE)[0] - expected)) < 1.5
    assert np.max(np.abs(frames_of(scene)[0] - expected)) > 2


def test_image_is_read_from_a_file(tmp_path):
    imsave(tmp_path / "ramp.png", np.tile(np.arange(64, dtype=np.uint8), (48, 1)), check_contrast=False)
    assert np.allclose(stimuli.Photograph(str(tmp_path / "ramp.png")).image[0], np.arange(64))
    (tmp_path / "text.png").write_text("this is no image")
    with pytest.raises(ValueError, match=r"text\.png' cannot be read"):
        stimuli.Photograph(tmp_path / "text.png")
