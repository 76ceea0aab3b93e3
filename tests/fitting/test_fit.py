"""The thin fit: observation model, bounds, recovery of known parameters."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

import lgmd2jax as lgmd
from lgmd2jax.fitting import Free, Observation, Target, fit
from lgmd2jax.fitting._fit import variance_explained

EYE = lgmd.Eye(rows=20, cols=28, degrees_per_pixel=4.0, fps=60.0)
FIXED = {"T_s": 5.0, "T_sfa": 5e-4, "tau2": 800.0, "T_ffi": 20.0}
OBSERVATION = Observation(baseline=5.0, gain=80.0, latency=30.0)


@pytest.fixture(scope="module")
def stimulus():
    return lgmd.stimuli.looming(EYE, l_over_v=20.0, contrast=-0.9, start_ms=-600.0, end_ms=300.0)


def target_of(model, stimulus):
    rate = np.asarray(OBSERVATION(model(stimulus.frames, 60.0).smp_adapted, stimulus.time))
    return Target(rate, None, np.ones_like(rate))


def test_observation_is_a_shift_a_scale_and_a_gaussian():
    time = jnp.arange(200) * 5.0
    potential = 0.5 + 0.3 * jnp.exp(-(((time - 400) / 60) ** 2))
    rate = Observation(baseline=3.0, gain=50.0, latency=35.0, smoothing=20.0)(potential, time)
    shifted = np.roll(np.asarray(potential), 7)
    expected = 3 + 50 * 2 * (gaussian_filter1d(shifted, 4.0, mode="nearest", truncate=8) - 0.5)
    np.testing.assert_allclose(rate, expected, atol=1e-3)
    between = Observation(latency=2.5, smoothing=1e-3)(potential, time)
    middle = 100 * 2 * (0.5 * (potential[1:] + potential[:-1]) - 0.5)
    np.testing.assert_allclose(between[1:], middle, atol=1e-9)


@pytest.mark.parametrize(("k", "tau3"), [(0.3, 250.0), (1.1, 600.0)])
def test_known_parameters_come_back(stimulus, k, tau3):
    truth = lgmd.LGMD2(lgmd.Parameters(**FIXED, k=k, tau3=tau3), lgmd.Soft(0.1), eye=EYE)
    start = lgmd.LGMD2(lgmd.Parameters(**FIXED), eye=EYE)
    result = fit(start, [(stimulus, target_of(truth, stimulus))], OBSERVATION, Free(k=(0.05, 2), tau3=(100, 1000)))
    np.testing.assert_allclose(result.model.parameters.k, k, rtol=1e-4)
    np.testing.assert_allclose(result.model.parameters.tau3, tau3, rtol=1e-4)
    assert result.result == "converged"
    assert isinstance(result.model.thresholds, lgmd.Hard)
    assert result.model.parameters.T_ffi == FIXED["T_ffi"]


def test_frames_without_weight_do_not_count(stimulus):
    truth = lgmd.LGMD2(lgmd.Parameters(**FIXED, k=0.4), lgmd.Soft(0.1))
    target = target_of(truth, stimulus)
    late = np.asarray(stimulus.time) > 150
    spoilt = Target(np.where(late, 1e3, target.values), None, np.where(late, 0.0, 1.0))
    result = fit(lgmd.LGMD2(lgmd.Parameters(**FIXED)), [(stimulus, spoilt)], OBSERVATION, Free(k=(0.05, 2)))
    np.testing.assert_allclose(result.model.parameters.k, 0.4, rtol=1e-4)


def test_variance_explained():
    target = Target(np.array([1.0, 2.0, 3.0, 99.0]), None, np.array([1.0, 1.0, 1.0, 0.0]))
    assert variance_explained(target.values, target) == 1
    assert variance_explained(np.full(4, 2.0), target) == 0
    np.testing.assert_allclose(variance_explained(np.array([1.5, 2.0, 2.5, 0.0]), target), 0.75)


def test_values_stay_within_their_bounds():
    free = Free(theta2=None, tau1=(10, 20))
    for raw in (-1e3, -2.0, 0.0, 3.0, 1e3):
        parameters = free.insert(lgmd.Parameters(), jnp.array([raw, raw]))
        assert 1 <= parameters.theta2 <= 6
        assert 10 <= parameters.tau1 <= 20
    assert free.insert(lgmd.Parameters(), jnp.zeros(2)).tau1 == 15


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        ({}, "free is empty"),
        ({"theta4": None}, "free parameter is 'theta4'; choose 'theta"),
        ({"tau1": (20, 10)}, "first bound must be below"),
        ({"tau1": (-5, 10)}, r"tau1 has the bound -5; it must lie in \(0, inf\)"),
        ({"tau1": (5, np.nan)}, "must be below"),
    ],
)
def test_bounds_that_make_no_sense_are_refused(bounds, message):
    with pytest.raises(ValueError, match=message):
        Free(**bounds)


def test_more_parameters_than_data_are_refused(stimulus):
    target = target_of(lgmd.LGMD2(), stimulus)
    one = Target(target.values, None, (np.arange(len(target.values)) == 5).astype(float))
    with pytest.raises(ValueError, match="2 parameters are free, but only 1 frames"):
        fit(lgmd.LGMD2(), [(stimulus, one)], OBSERVATION, Free(k=None, tau3=None))


@pytest.mark.parametrize("name", ["gain", "smoothing"])
def test_observation_refuses_what_is_not_positive(name):
    with pytest.raises(ValueError, match=f"{name} is 0"):
        Observation(**{name: 0.0})
