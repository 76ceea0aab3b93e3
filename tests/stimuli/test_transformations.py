"""Renderers as pure functions of array parameters: jit, vmap, derivatives."""

import dataclasses
import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lgmd2jax import Eye, stimuli

EYE = Eye(rows=12, cols=16, degrees_per_pixel=5.0, fps=50.0)
PINHOLE = Eye(rows=12, cols=16, degrees_per_pixel=5.0, fps=50.0, projection="pinhole")
WINDOW: dict[str, Any] = {"start_ms": -200, "end_ms": 60}
PICTURE = 110 + 50 * np.sin(np.arange(30) / 3)[:, None] * np.cos(np.arange(40) / 4)[None, :]
DRIFT = stimuli.Photograph(PICTURE, speed=30)

# A family, what is fixed, and values for what is differentiated. They keep clear of the frames on which something
# starts or stops, where there are two slopes.
CASES = {
    "looming": ("looming", {"stop_angle": 50}, {"l_over_v": 41.3, "contrast": -0.7, "azimuth": 3.1, "elevation": -2.2}),
    "square with checks": ("looming", {"shape": "square", "checks": 3}, {"l_over_v": 41.3, "check_contrast": -0.3}),
    "near miss": ("looming", {"start_angle": 11}, {"l_over_v": 23.3, "deviation": 17.3, "deviation_direction": 31.0}),
    "over a drifting photograph": ("looming", {"background": DRIFT}, {"l_over_v": 41.3, "contrast": -0.5}),
    "translation": ("translating", {}, {"speed": 613.0, "size": 14.2, "direction": 33.0, "start": -31.7}),
    "passing": ("translating", {}, {"distance_cm": 31.0, "size_cm": 9.1, "speed_cm_s": 703.0}),
    "elongation": ("elongating", {}, {"speed": 613.0, "width": 14.2, "level": 30.0}),
    "ramp": ("luminance", {}, {"ramp_ms": 47.3, "contrast": -0.4, "fraction": 0.23}),
    "sine": ("grating", {}, {"spatial_frequency": 0.031, "temporal_frequency": 3.3, "direction": 12.0}),
    "square wave": (
        "grating",
        {"waveform": "square"},
        {"spatial_frequency": 0.031, "contrast": 0.8, "direction": 12.0},
    ),
    "turning": ("turning", {"background": stimuli.Panorama(PICTURE)}, {"speed": 61.3}),
}


@pytest.mark.parametrize(("name", "fixed", "free"), CASES.values(), ids=CASES)
def test_slopes_are_those_of_finite_differences(name, fixed, free):
    values = jnp.array(list(free.values()))

    @jax.jit
    def frames(values):
        return stimuli.FAMILIES[name](EYE, **dict(zip(free, values, strict=True)), **fixed, **WINDOW).frames

    slopes = jax.jit(jax.jacfwd(frames))(values)
    assert np.all(np.isfinite(slopes))
    for i in range(len(values)):
        step = 1e-6 * jnp.maximum(1, jnp.abs(values[i])) * jnp.eye(len(values))[i]
        difference = (frames(values + step) - frames(values - step)) / (2 * step[i])
        scale = np.max(np.abs(difference))
        assert scale > 0, f"{list(free)[i]} changes nothing"
        assert np.max(np.abs(slopes[..., i] - difference)) < 1e-5 * scale


def test_reverse_mode_agrees_with_forward_mode():
    def total(values):
        stimulus = stimuli.looming(EYE, l_over_v=values[0], contrast=values[1], azimuth=values[2], **WINDOW)
        return jnp.sin(stimulus.frames[:, 3:, 5:]).sum()

    values = jnp.array([33.3, -0.6, 4.4])
    assert np.allclose(jax.jit(jax.grad(total))(values), jax.jit(jax.jacfwd(total))(values), rtol=1e-9)


EXTREMES = {
    "off screen": {"azimuth": 80.0},
    "over the whole field": {"stop_angle": 178.0, "l_over_v": 60.0},
    "hardly there": {"start_angle": 1e-6, "l_over_v": 1e-6},
    "straight past": {"start_angle": 20.0, "deviation": 60.0},
    "without a deviation": {"deviation": 0.0},
}


@functools.partial(jax.jit, static_argnums=(0, 1))
@functools.partial(jax.jacfwd, argnums=2)
def slopes_of_looming(eye, shape, point):
    return stimuli.looming(eye, shape=shape, checks=2, **point, start_ms=-40, end_ms=40).frames


@pytest.mark.parametrize(("eye", "shape"), [(EYE, "disc"), (PINHOLE, "square")], ids=["equidistant", "pinhole"])
def test_slopes_are_finite_everywhere(eye, shape):
    usual = {"l_over_v": 40.0, "azimuth": 0.0, "deviation": 0.0, "start_angle": 2.0, "stop_angle": 80.0}
    for name, extreme in EXTREMES.items():
        slopes = slopes_of_looming(eye, shape, usual | extreme)
        assert all(np.all(np.isfinite(slope)) for slope in slopes.values()), name


def test_a_thousand_conditions_in_one_call():
    contrast, l_over_v = (
        jnp.ravel(axis) for axis in jnp.meshgrid(jnp.linspace(-1, 0.2, 25), jnp.linspace(5, 80, 40), indexing="ij")
    )
    traces = []

    @jax.jit
    @jax.vmap
    def render(contrast, l_over_v):
        traces.append(1)
        return stimuli.looming(EYE, contrast=contrast, l_over_v=l_over_v, **WINDOW)

    batch = render(contrast, l_over_v)
    assert batch.frames.shape == (1000, 14, 12, 16)
    assert len(traces) == 1
    for i in (0, 517, 999):
        single = stimuli.looming(EYE, contrast=float(contrast[i]), l_over_v=float(l_over_v[i]), **WINDOW)
        assert np.max(np.abs(batch.frames[i] - single.frames)) < 1e-9
        assert batch.parameters["l_over_v"][i] == pytest.approx(single.parameters["l_over_v"])


def test_every_number_of_a_translation_can_be_a_batch():
    axes = {"size": (11, 23), "speed": (90, 400), "azimuth": (0, -7), "direction": (10, 50), "level": (30, 90)}

    def render(**point):
        return stimuli.translating(EYE, start_ms=0, end_ms=200, **point)

    batch = jax.jit(jax.vmap(lambda point: render(**point).frames))(
        {name: jnp.array(axis) for name, axis in axes.items()}
    )
    for i, frames in enumerate(batch):
        assert np.max(np.abs(frames - render(**{name: axis[i] for name, axis in axes.items()}).frames)) < 1e-9


def test_another_value_compiles_nothing(caplog):
    def compiled():
        return [text for text in caplog.messages if "Finished XLA compilation" in text]

    stimuli.looming(EYE, l_over_v=30, contrast=-0.5, **WINDOW)
    with jax.log_compiles():
        stimuli.looming(EYE, l_over_v=31, contrast=-0.6, **WINDOW)
        assert not compiled()
        stimuli.looming(dataclasses.replace(EYE, rows=EYE.rows + 1), l_over_v=31, contrast=-0.6, **WINDOW)
        assert compiled()


def test_a_window_cannot_follow_from_a_batch():
    with pytest.raises(ValueError, match="start_ms is not given"):
        jax.vmap(lambda l_over_v: stimuli.looming(EYE, l_over_v=l_over_v).frames)(jnp.array([10.0, 20.0]))


def test_frames_follow_the_precision_in_force():
    with jax.enable_x64(False):
        single = stimuli.looming(EYE, **WINDOW).frames
    assert single.dtype == jnp.float32
    assert np.max(np.abs(single - stimuli.looming(EYE, **WINDOW).frames)) < 0.05
