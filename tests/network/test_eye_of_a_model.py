"""A model for another eye: there and back, the same answer to what has the same angular size, and refusals."""

import dataclasses

import jax
import numpy as np
import pytest

import lgmd2jax as lgmd

EYE = lgmd.Eye(rows=24, cols=32, degrees_per_pixel=3.0, fps=60.0)
WIDE = dataclasses.replace(EYE, rows=48, cols=64)
ALL = ("size", "shunt", "lag", "membrane")
MODELS = {
    "the paper's circuit": lgmd.LGMD2(lgmd.Parameters(k=0.5, T_ffi=20.0), eye=EYE),
    "size and shunt": lgmd.LGMD2(lgmd.Parameters(k=0.5, A_ffi=0.1), eye=EYE, mechanisms=("size", "shunt")),
    "all mechanisms": lgmd.LGMD2(lgmd.Parameters(k=0.5, A_ffi=0.1), eye=EYE, mechanisms=ALL),
    "LGMD1": lgmd.YueRindLGMD1(lgmd.YueRindParameters(k=0.5, T_ffi=20.0), eye=EYE),
}


@pytest.mark.parametrize("name", MODELS)
def test_an_object_in_a_field_of_four_times_the_area_means_the_same(name):
    """With the ground of one grey level, the object changes the same pixels, and every mean over pixels is a quarter.

    So what the cell computes is exactly the same, whichever mean its thresholds are compared with.
    """
    model, there = MODELS[name], lgmd.at_eye(MODELS[name], WIDE)
    near, far = (
        own(lgmd.stimuli.looming(own.eye, l_over_v=40.0, contrast=-0.9, stop_angle=60.0).frames)
        for own in (model, there)
    )
    assert float(near.smp.max()) > 0.7
    for channel in ("mp", "smp", "smp_adapted", "spikes", "collision"):
        np.testing.assert_allclose(getattr(far, channel), getattr(near, channel), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(4 * far.ffi, near.ffi, rtol=1e-9)


def test_a_finer_raster_of_one_field_changes_no_parameter():
    fine = dataclasses.replace(EYE, rows=48, cols=64, degrees_per_pixel=1.5)
    there = lgmd.at_eye(MODELS["all mechanisms"], fine)
    assert there.eye == fine
    for one, other in zip(jax.tree.leaves(there), jax.tree.leaves(MODELS["all mechanisms"]), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)


def test_rate_and_field_there_and_back():
    model = MODELS["all mechanisms"]
    there = lgmd.at_eye(model, dataclasses.replace(WIDE, fps=30.0))
    assert there.eye == dataclasses.replace(WIDE, fps=30.0)
    scaled = {name: float(getattr(there.parameters, name)) for name in ("k", "T_ffi", "A_ffi", "T_s", "tau1", "T_p")}
    assert scaled == pytest.approx({"k": 0.25, "T_ffi": 5.0, "A_ffi": 0.025, "T_s": 20.0, "tau1": 30.0, "T_p": 19.0})
    back = lgmd.at_eye(there, EYE)
    for one, other in zip(jax.tree.leaves(back), jax.tree.leaves(model), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)


def test_its_own_eye_changes_nothing():
    assert lgmd.at_eye(MODELS["LGMD1"], EYE) is MODELS["LGMD1"]


def test_the_field_of_a_camera_counts_by_its_central_pixel():
    camera = lgmd.Eye(rows=24, cols=32, degrees_per_pixel=3.0, fps=60.0, projection="pinhole")
    assert camera.field_area == EYE.field_area == 24 * 32 * 9


@pytest.mark.parametrize(
    ("model", "eye", "message"),
    [
        (lgmd.LGMD2(), EYE, "the model has no eye, so its field of view is not known"),
        (lgmd.LGMD2(eye=lgmd.Eye.preset("paper")), EYE, "the model's eye has no degrees_per_pixel"),
        (MODELS["LGMD1"], lgmd.Eye.preset("paper"), "eye has no degrees_per_pixel"),
    ],
)
def test_a_field_that_is_not_known_is_refused(model, eye, message):
    with pytest.raises(ValueError, match=message):
        lgmd.at_eye(model, eye)
