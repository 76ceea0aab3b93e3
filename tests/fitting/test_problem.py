"""The objective of a fit against single calls of the model, padding, and the search over the cell."""

import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.fitting import Free, Tie
from lgmd2jax.fitting._problem import problem_of
from lgmd2jax.fitting._search import search_cell, sobol
from lgmd2jax.fitting._uncertainty.jacobian import sensitivity

SMALL = lgmd.Eye(rows=12, cols=16, degrees_per_pixel=8.0, fps=30.0)
FAST = lgmd.Eye(rows=12, cols=16, degrees_per_pixel=8.0, fps=60.0)
OTHER = lgmd.Eye(rows=10, cols=14, degrees_per_pixel=8.0, fps=30.0)
OBSERVATION = lgmd.Observation(baseline=3.0, gain=80.0, latency=40.0, smoothing=30.0)
FREE = Free(theta2=(1, 6), tau1=None, tau2=None, T_ffi=(1, 40), tau3=None, gain=(10, 200), baseline=(0, 20))
TRUTH = lgmd.LGMD2(lgmd.Parameters(theta2=2.0, T_ffi=25.0, tau2=60.0), N_ts=2)
Z = np.array([0.3, 0.5, 0.4, 0.7, 0.5, 0.4, 0.3])


def loom(eye, l_over_v=60.0, end_ms=300.0):
    return lgmd.stimuli.looming(eye, l_over_v=l_over_v, contrast=-0.9, start_ms=-900.0, end_ms=end_ms)


@pytest.fixture(scope="module")
def pairs():
    """Two rasters, three lengths, two frame rates, all channels, one condition with two targets in one channel."""
    stimuli = [loom(SMALL), loom(FAST), loom(OTHER), loom(SMALL, 40.0, 100.0)]
    rng = np.random.default_rng(0)

    def target(channel, stimulus, **settings):
        return lgmd.Target(channel, rng.uniform(0.5, 1, len(stimulus.time)), **settings).on(stimulus)

    return [
        (stimuli[0], [target("smp_adapted", stimuli[0]), target("spikes", stimuli[0], error=0.3)]),
        (stimuli[1], [target("rate", stimuli[1], error=5.0)]),
        (stimuli[2], [target("smp", stimuli[2], weight=4.0)]),
        (
            stimuli[3],
            [target("smp_adapted", stimuli[3]), target("smp_adapted", stimuli[3]), target("rate", stimuli[3])],
        ),
    ]


@pytest.fixture(scope="module")
def problem(pairs):
    return problem_of(TRUTH, OBSERVATION, FREE, pairs, "squares")


@pytest.mark.parametrize("temperature", [None, 0.5])
def test_residuals_are_those_of_single_calls(problem, pairs, temperature):
    parameters, observation = FREE.insert(TRUTH.parameters, OBSERVATION, Z)
    thresholds = lgmd.Hard() if temperature is None else lgmd.Soft(temperature)
    model = lgmd.LGMD2(parameters, thresholds, N_ts=2)
    hot = None if temperature is None else jnp.asarray(temperature)
    seen = sensitivity(problem, jnp.asarray(Z), hot)
    expected = 0.0
    for (stimulus, targets), places in zip(pairs, problem.places, strict=True):
        response = model(stimulus.frames, stimulus.fps)
        for target, (batch, slot, row) in zip(targets, places, strict=True):
            if target.channel == "rate":
                curve = observation(response.smp_adapted, stimulus.time)
            else:
                curve = getattr(response, target.channel)
            found = seen.curves[batch][slot][row][: len(stimulus.time)]
            np.testing.assert_allclose(found, curve, atol=1e-9)
            expected += np.sum((target.scale * (np.asarray(curve) - target.values)) ** 2) / target.thinning
    np.testing.assert_allclose(np.sum(np.square(seen.residuals)), expected, rtol=1e-9)
    assert problem.known().sum() == sum(len(target.values) for _, targets in pairs for target in targets)
    assert len(problem.known()) == len(seen.residuals)


def test_the_jacobian_is_that_of_finite_differences(problem):
    hot, step = jnp.asarray(1.0), 1e-6
    seen = sensitivity(problem, jnp.asarray(Z), hot)
    for i in range(len(FREE)):
        up, down = (sensitivity(problem, jnp.asarray(Z).at[i].add(sign * step), hot) for sign in (1, -1))
        slope = (up.residuals - down.residuals) / (2 * step)
        np.testing.assert_allclose(seen.jacobian[:, i], slope, atol=2e-5 * float(jnp.abs(seen.jacobian).max()))


def test_the_cell_is_searched_on_the_same_potentials(problem):
    """The loss that the search reports is the loss of a whole evaluation at the point that it returns."""
    found = search_cell(problem, Z, sobol(5, 64, (1,)))
    loss = 0.5 * np.sum(np.square(problem.residuals(found.z, None)))
    np.testing.assert_allclose(found.loss, loss, rtol=1e-9)
    np.testing.assert_allclose(found.loss_before, 0.5 * np.sum(np.square(problem.residuals(Z, None))), rtol=1e-9)
    assert found.loss < found.loss_before
    pixels = list(problem.pixel_indices)
    np.testing.assert_array_equal(np.asarray(found.z)[pixels], Z[pixels])
    assert np.all((np.asarray(found.z) >= 0) & (np.asarray(found.z) <= 1))


def test_gain_and_baseline_are_solved_for():
    """With the right cell a search needs no luck for what the rate is linear in."""
    stimulus = loom(SMALL)
    rate = OBSERVATION(TRUTH(stimulus.frames, 30.0).smp_adapted, stimulus.time)
    pairs = [(stimulus, [lgmd.Target("rate", np.asarray(rate)).on(stimulus)])]
    free = Free(gain=(10, 200), baseline=(0, 20))
    problem = problem_of(TRUTH, lgmd.Observation(latency=40.0, smoothing=30.0), free, pairs, "squares")
    found = search_cell(problem, np.array([0.9, 0.9]), sobol(2, 4, (1,)))
    values = free.values(found.z)
    np.testing.assert_allclose([values["gain"], values["baseline"]], [80, 3], rtol=1e-6)
    tied = Free(gain=(10, 200), baseline=Tie("gain", 3 / 80))
    problem = problem_of(TRUTH, lgmd.Observation(latency=40.0, smoothing=30.0), tied, pairs, "squares")
    found = search_cell(problem, np.array([0.9]), sobol(1, 64, (1,)))
    np.testing.assert_allclose(tied.values(found.z)["gain"], 80, rtol=0.05)


def test_sobol_points_fill_the_box_and_follow_the_seed():
    points = sobol(3, 100, (4, 2))
    assert points.shape == (100, 3)
    np.testing.assert_allclose(points.mean(axis=0), 0.5, atol=0.02)
    np.testing.assert_array_equal(points, sobol(3, 100, (4, 2)))
    assert not np.array_equal(points, sobol(3, 100, (4, 3)))
    assert sobol(0, 100, (1,)).shape == (1, 0)
