"""Misuse: one line that names the argument, the value and the cure."""

import re

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd
import pint
import pytest
import quantities as pq

from lgmd2jax import Eye, stimuli

EYE = Eye(rows=12, cols=16, degrees_per_pixel=5.0, fps=50.0)
SCREEN = Eye(rows=12, cols=16, degrees_per_pixel=None, fps=50.0)
GROWTH = {"growth_px": 9, "start_radius_px": 1, "stop_radius_px": 5}

BAD = {
    "too bright": ("looming", {"contrast": 3, "background": 100}, "contrast is 3 on a background of 100.* 0..255"),
    "too dark": ("looming", {"contrast": -1.1}, "contrast is -1.1"),
    "level": ("looming", {"level": 256}, "level is 256 grey levels"),
    "background": ("looming", {"background": -1}, "background is -1"),
    "contrast and level": ("looming", {"contrast": -0.5, "level": 20}, "contrast and level are both given"),
    "speeds": ("looming", {"l_over_v": 20, "growth": 50}, "l_over_v and growth are both given"),
    "no speed": ("looming", {"l_over_v": 0}, "l_over_v is 0 ms"),
    "infinite speed": ("looming", {"l_over_v": np.inf}, "l_over_v is inf"),
    "a batch": ("looming", {"l_over_v": np.array([10.0, 20.0])}, "l_over_v is .*jax.vmap"),
    "text": ("looming", {"l_over_v": "fast"}, "l_over_v is 'fast'"),
    "a typo": ("looming", {"l_v": 20}, "looming takes no 'l_v'; choose 'l_over_v'"),
    "nothing to stop": ("looming", {"stop_angle": 2}, "make stop_angle the larger"),
    "no start": ("looming", {"start_angle": 0}, "start_angle is 0 degrees"),
    "a start beyond the field": ("looming", {"start_angle": 70, "stop_angle": 75}, "start_angle makes .* field"),
    "all round": ("looming", {"stop_angle": 180}, "stop_angle is .*180.* 0..179"),
    "sideways": ("looming", {"deviation": 90}, "deviation is 90"),
    "half of a growth": ("looming", {"growth_px": 9}, "growth_px is given without start_radius_px"),
    "a growth that stops": ("looming", {**GROWTH, "acceleration_px": -20}, "acceleration_px is -20"),
    "a distance that is none": ("looming", {"distance": 3.0}, "distance is 3.0; give a Distance"),
    "shape": ("looming", {"shape": "disk"}, "shape is 'disk'; choose 'disc' or 'square'"),
    "checks": ("looming", {"checks": -1}, "checks is -1"),
    "receding inwards": ("receding", {"start_angle": 2, "stop_angle": 80}, "make start_angle the larger"),
    "hold": ("approach_recession", {"hold_ms": -1}, "hold_ms is -1"),
    "window": ("looming", {"start_ms": 10, "end_ms": 0}, "fewer than 2 frames"),
    "window of text": ("looming", {"start_ms": "now"}, "start_ms is 'now'"),
    "size": ("translating", {"size": -1}, "size is -1 degrees"),
    "a size beyond the field": ("translating", {"size": 70}, "size makes an object of 14 px, beyond the field of 12"),
    "speed": ("translating", {"speed": 0}, "speed is 0 deg/s"),
    "end before start": ("translating", {"start": 10, "stop": -10}, "start is 10 and stop -10; swap them"),
    "profile": ("translating", {"profile": "acelerating"}, "choose 'accelerating'"),
    "half of a distance": ("translating", {"distance_cm": 30}, "distance_cm is given without size_cm"),
    "near": ("translating", {"distance_cm": 1, "size_cm": 9, "speed_cm_s": 9}, "size_cm makes an object"),
    "mixed units": ("translating", {"speed": 9, "speed_px": 9}, "speed and speed_px are both given"),
    "oblique bar": ("elongating", {"direction": 45}, "direction is 45 degrees"),
    "wide bar": ("shortening", {"width": 61}, "width makes an object"),
    "fraction": ("luminance", {"fraction": 1.5}, "fraction is 1.5"),
    "no fraction": ("luminance", {"fraction": 0}, "fraction is 0"),
    "ramp": ("luminance", {"ramp_ms": -1}, "ramp_ms is -1"),
    "alias in space": ("grating", {"spatial_frequency": 0.1}, "spatial_frequency aliases: 0.5 cycles a pixel"),
    "the paper's 100 cycles": ("grating", {"cycles": 100}, "cycles aliases: 6.25 cycles a pixel"),
    "alias in time": (
        "grating",
        {"cycles": 2, "temporal_frequency": 25},
        "temporal_frequency aliases: 25 Hz.* 50 frames",
    ),
    "bright stripes": ("grating", {"cycles": 2, "background": 200}, "contrast is 1 on a mean of 200"),
    "waveform": ("grating", {"cycles": 2, "waveform": "sinus"}, "waveform is 'sinus'; choose 'sine'"),
    "turn": ("turning", {"direction": "rigth"}, "direction is 'rigth'; choose 'right'"),
    "a flat scene": ("turning", {"background": stimuli.Photograph()}, "turns in a Panorama"),
}


@pytest.mark.parametrize(("family", "arguments", "message"), BAD.values(), ids=BAD)
@pytest.mark.usefixtures("untyped")
def test_misuse_is_refused_in_one_line(family, arguments, message):
    with pytest.raises(ValueError, match=message) as error:
        stimuli.FAMILIES[family](EYE, **arguments)
    assert "\n" not in str(error.value)
    assert re.match(r"[a-z_]+ |contrast", str(error.value))


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize("eye", ["dark", None, Eye])
def test_what_is_no_eye_is_refused(eye):
    with pytest.raises(ValueError, match=r"eye is .*; give an Eye"):
        stimuli.looming(eye, l_over_v=20.0)


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("frames", "fps", "time", "message"),
    [
        (np.zeros((3, 4, 4)), "30", np.arange(3.0), "fps is '30'; give a number"),
        (np.zeros((3, 4, 4)), 30.0, np.arange(2.0), r"frames has shape \(3, 4, 4\) and time \(2,\); give"),
        (np.zeros((4, 4)), 30.0, np.arange(4.0), r"frames has shape \(4, 4\) and time \(4,\); give \(time, row, col\)"),
        (
            np.zeros((3, 4, 4)),
            30.0,
            np.arange(3) / 30,
            "time rises by 0.03333 a frame at 30 fps, as in s; give",
        ),
    ],
)
def test_a_stimulus_of_your_own_has_a_time_in_ms_for_each_frame(frames, fps, time, message):
    with pytest.raises(ValueError, match=message):
        stimuli.Stimulus(frames, fps, time)


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize("family", ["looming", "receding", "translating", "elongating", "turning", "grating"])
def test_degrees_are_refused_on_a_screen_in_pixels(family):
    with pytest.raises(ValueError, match="has no degrees_per_pixel"):
        stimuli.FAMILIES[family](SCREEN)


PICTURES = {
    "name": (lambda: stimuli.Photograph("gras"), "image is 'gras'.* choose 'grass'"),
    "shape": (lambda: stimuli.Photograph(np.zeros((4, 4, 3))), "image has shape"),
    "levels": (lambda: stimuli.Photograph(np.full((4, 4), 300.0)), "outside of 0..255"),
    "contrast": (lambda: stimuli.Photograph("camera", contrast=3), "takes the picture to"),
    "level": (lambda: stimuli.Photograph("camera", level=250), "takes the picture to"),
    "width": (lambda: stimuli.Panorama("grass", width=200), "width is 200 degrees"),
    "slope": (lambda: stimuli.Rolling(slope_height_cm=30, slope_length_cm=20), "slope_height_cm is 30"),
    "ball": (lambda: stimuli.Rolling(radius_cm=0), "radius_cm is 0"),
    "table": (lambda: stimuli.Tabulated([0.0, 1.0], [1.0, 2.0, 3.0]), "two equal columns"),
    "order": (lambda: stimuli.Tabulated([0.0, 1.0], [1.0, 2.0]), "distance does not fall"),
}


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(("make", "message"), PICTURES.values(), ids=PICTURES)
def test_bad_pictures_and_distances_are_refused_in_one_line(make, message):
    with pytest.raises(ValueError, match=message) as error:
        make()
    assert "\n" not in str(error.value)


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize("setting", [{"noise": -1}, {"flicker": 2}, {"blur": -1}, {"bits": 0}, {"bits": 8.5}])
def test_bad_cameras_are_refused_in_one_line(setting):
    clip = stimuli.Stimulus(jnp.zeros((2, 3, 3)), 50.0, jnp.arange(2.0))
    with pytest.raises(ValueError, match=f"{next(iter(setting))} is"):
        stimuli.camera(clip, jax.random.key(0), **setting)


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    "value",
    [0.02 * pint.UnitRegistry().s, 20 * pq.ms, pd.Timedelta(20, "ms"), np.timedelta64(20, "ms"), True, "20"],
    ids=["pint", "quantities", "pandas", "numpy", "bool", "text"],
)
def test_what_is_no_plain_number_is_refused(value):
    """Numpy drops units: 0.02 s was 0.02 ms."""
    with pytest.raises(ValueError, match=r"l_over_v is .*; give one number, in ms, and map a batch"):
        stimuli.looming(EYE, l_over_v=value, start_ms=-100, end_ms=0)


def test_traced_values_go_unchecked():
    frames = jax.jit(lambda contrast: stimuli.looming(EYE, contrast=contrast, start_ms=-100, end_ms=0).frames)(9.0)
    assert frames.max() > 255
