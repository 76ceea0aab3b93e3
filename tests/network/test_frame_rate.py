"""A model at another frame rate: there and back, and the same answer to the same movie."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax._network.retina import persistence

EYE = lgmd.Eye(rows=12, cols=16, degrees_per_pixel=6.0, fps=100.0)
MODEL = lgmd.LGMD2(lgmd.Parameters(T_s=3.0, T_ffi=20.0, T_sfa=3e-4, k=0.3, sigma1=0.5), eye=EYE, N_ts=9)


def test_there_and_back():
    fine = lgmd.at_frame_rate(MODEL, 200.0)
    assert fine.eye == dataclasses.replace(EYE, fps=200.0)
    assert fine.N_ts == 19
    values = {name: float(getattr(fine.parameters, name)) for name in ("T_s", "T_ffi", "T_sfa", "k", "sigma1", "N_sp")}
    assert values == pytest.approx(
        {"T_s": 1.5, "T_ffi": 10.0, "T_sfa": 1.5e-4, "k": 0.15, "sigma1": 0.5**0.5, "N_sp": 12.0}
    )
    back = lgmd.at_frame_rate(fine, 100.0)
    assert back.eye == EYE
    assert back.N_ts == MODEL.N_ts
    for one, other in zip(jax.tree.leaves(back), jax.tree.leaves(MODEL), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)


def test_time_constants_stay():
    fine = lgmd.at_frame_rate(MODEL, 30.0)
    for name in ("tau1", "tau2", "tau3", "theta1", "theta2", "w_bias", "T_sp"):
        assert float(getattr(fine.parameters, name)) == float(getattr(MODEL.parameters, name))


def test_persistence_over_one_frame_fades_as_fast():
    model = dataclasses.replace(MODEL, n_p=1)
    fine = lgmd.at_frame_rate(model, 200.0)
    own, there = (float(persistence(it.parameters.u, 1)[0]) for it in (model, fine))
    assert there**2 == pytest.approx(own)


def test_a_model_without_adaptation_stays_without():
    off = lgmd.ablate(MODEL, "sfa", "ffi")
    slow = lgmd.at_frame_rate(off, 30.0)
    assert float(slow.parameters.T_sfa) == -1
    stimulus = lgmd.stimuli.looming(dataclasses.replace(EYE, fps=30.0), l_over_v=20.0, stop_angle=60.0)
    response = slow(stimulus.frames)
    np.testing.assert_allclose(response.smp_adapted, response.smp, atol=1e-6)


def test_slow_motion_is_answered_alike():
    """Twice the frames of an edge slower than a pixel a frame: the SMP goes the same way, sums over frames apart."""
    courses, own = [], dataclasses.replace(MODEL, parameters=dataclasses.replace(MODEL.parameters, sigma1=0.0))
    for fps in (100.0, 200.0):
        model, eye = lgmd.at_frame_rate(own, fps), dataclasses.replace(EYE, fps=fps)
        stimulus = lgmd.stimuli.translating(eye, size=20.0, speed=60.0, stop=30.0, start=-30.0)
        courses.append(np.interp(np.arange(200.0, 900.0, 50.0), stimulus.time, model(stimulus.frames).smp))
    assert courses[0].min() > 0.6
    np.testing.assert_allclose(courses[0], courses[1], atol=0.05)


def test_it_can_be_traced():
    @jax.jit
    def scaled(T_s):
        model = dataclasses.replace(MODEL, parameters=dataclasses.replace(MODEL.parameters, T_s=T_s))
        return lgmd.at_frame_rate(model, 50.0).parameters.T_s

    assert float(scaled(jnp.asarray(3.0))) == 6.0


def test_what_has_no_rate_is_refused():
    with pytest.raises(ValueError, match="no eye"):
        lgmd.at_frame_rate(lgmd.LGMD2(), 100.0)
    with pytest.raises(ValueError, match="fps is 0"):
        lgmd.at_frame_rate(MODEL, 0)
