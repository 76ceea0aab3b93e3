"""Levels, contrasts and frequencies: luminance changes, gratings, and what is lost by quantisation."""

from typing import Any

import jax
import numpy as np
import pytest

from lgmd2jax import Eye, stimuli

EYE = Eye(rows=32, cols=40, degrees_per_pixel=2.0, fps=100.0)
WINDOW: dict[str, Any] = {"start_ms": -100, "end_ms": 990}


def digital(stimulus):
    """The same in 8 bits."""
    return stimuli.camera(stimulus, jax.random.key(0), noise=0)


@pytest.mark.parametrize(("background", "contrast"), [(200.0, -0.9), (20.0, 9.0), (110.3, -0.37)])
def test_weber_contrast_comes_out_as_asked_and_within_half_a_level_in_8_bits(background, contrast):
    stimulus = stimuli.looming(EYE, contrast=contrast, background=background, start_ms=-100, end_ms=100)
    inside, outside = stimulus.frames[-1, 16, 20], stimulus.frames[:, 0, 0]
    assert (inside - outside[-1]) / outside[-1] == pytest.approx(contrast)
    assert np.allclose(outside, background)
    assert np.all(np.abs(digital(stimulus).frames - stimulus.frames) <= 0.5 + 1e-9)
    assert np.array_equal(digital(stimulus).frames, np.rint(digital(stimulus).frames))


@pytest.mark.parametrize(
    ("cycles", "direction", "hertz"),
    [(4, 0, 5.0), (7, 90, 10.0), (5, 180, 20.0), (5, np.degrees(np.arctan2(3, 4)), 10.0)],
)
def test_sine_grating_is_one_line_of_the_spectrum_at_the_asked_place(cycles, direction, hertz):
    eye = Eye(rows=40, cols=40, degrees_per_pixel=2.0, fps=100.0)
    stimulus = stimuli.grating(
        eye, cycles=cycles, temporal_frequency=hertz, direction=direction, contrast=0.8, **WINDOW
    )
    moving = np.asarray(stimulus.frames)[np.asarray(stimulus.time) >= 0]
    spectrum = np.abs(np.fft.fftn(moving)) / moving.size
    assert spectrum[0, 0, 0] == pytest.approx(110)
    heading = np.radians(direction)
    column, row = round(cycles * np.cos(heading)), round(-cycles * np.sin(heading))
    line = (round(-hertz), row, column)
    assert spectrum[line] == pytest.approx(110 * 0.8 / 2)
    spectrum[0, 0, 0] = spectrum[line] = spectrum[tuple(-k for k in line)] = 0
    assert spectrum.max() < 0.01 * 110 * 0.8 / 2


def test_cycles_per_degree_are_those_of_the_middle_of_the_field():
    per_degree = stimuli.grating(EYE, spatial_frequency=0.1, **WINDOW).frames
    assert np.allclose(per_degree, stimuli.grating(EYE, cycles=0.1 * 80, **WINDOW).frames)


@pytest.mark.parametrize("waveform", ["sine", "square"])
def test_michelson_contrast_and_mean_come_out_as_asked(waveform):
    stimulus = stimuli.grating(EYE, cycles=2, contrast=0.6, waveform=waveform, background=100, **WINDOW)
    before, moving = np.split(np.asarray(stimulus.frames), [np.searchsorted(stimulus.time, 0)])
    assert np.all(before == 100)
    bright, dark = moving.max(), moving.min()
    assert (bright - dark) / (bright + dark) == pytest.approx(0.6, abs=2e-3)
    assert moving.mean() == pytest.approx(100)
    assert np.all(np.abs(digital(stimulus).frames - stimulus.frames) <= 0.5 + 1e-9)


@pytest.mark.parametrize("direction", [0.0, 90.0, 27.0])
def test_square_grating_is_the_mean_of_a_fine_one(direction):
    fine = 50
    stimulus = stimuli.grating(
        EYE, cycles=6.3, direction=direction, contrast=1, waveform="square", start_ms=0, end_ms=50
    )
    x = (np.arange(40 * fine) + 0.5) / fine - 20
    y = 16 - (np.arange(32 * fine) + 0.5) / fine
    wave, heading = 6.3 / 40, np.radians(direction)
    phase = wave * (np.cos(heading) * x[None, :] + np.sin(heading) * y[:, None]) - 4 * 0.05
    expected = 110 * (1 + np.where(phase % 1 < 0.5, 1.0, -1.0)).reshape(32, fine, 40, fine).mean((1, 3))
    assert np.max(np.abs(stimulus.frames[-1] - expected)) < 0.02 * 220


def test_grating_stands_after_its_motion():
    stimulus = stimuli.grating(EYE, duration_ms=200, start_ms=-100, end_ms=990)
    still = np.asarray(stimulus.frames)[np.asarray(stimulus.time) >= 200]
    assert np.all(still == still[0])
    assert stimulus.courses["drift_cycles"][-1] == pytest.approx(0.8)


def test_step_of_light_is_there_on_frame_zero_and_stays():
    stimulus = stimuli.luminance(EYE, level=70, background=150, **WINDOW)
    expected = np.where(np.asarray(stimulus.time) < 0, 150.0, 70.0)
    assert np.allclose(stimulus.frames, expected[:, None, None])


def test_ramp_of_a_part_of_the_field_goes_and_comes_back():
    stimulus = stimuli.luminance(
        EYE, contrast=0.5, background=100, fraction=0.25, ramp_ms=200, hold_ms=300, start_ms=-100, end_ms=990
    )
    time = np.asarray(stimulus.time)
    level = np.interp(time, [0, 200, 500, 700], [100, 150, 150, 100])
    inside = np.zeros((32, 40), bool)
    inside[8:24, 10:30] = True
    assert np.allclose(stimulus.frames, np.where(inside, level[:, None, None], 100))
    assert np.allclose(stimulus.courses["level"], level)
