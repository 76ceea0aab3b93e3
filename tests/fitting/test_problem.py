"""The objective of a fit against single calls of the model, padding, and the search over the cell."""

import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.fitting import Free, Linear, Tie
from lgmd2jax.fitting._cell_search import search_cell
from lgmd2jax.fitting._problem import chi2_residuals, problem_of
from lgmd2jax.fitting._search.points import sobol
from lgmd2jax.fitting._uncertainty.jacobian import sensitivity_at

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
    here = sensitivity_at(problem, jnp.asarray(Z), hot)
    expected = 0.0
    for (stimulus, targets), places in zip(pairs, problem.places, strict=True):
        response = model(stimulus.frames, stimulus.fps)
        for target, (batch, slot, row) in zip(targets, places, strict=True):
            if target.channel == "rate":
                curve = observation(response.smp_adapted, stimulus.time)
            else:
                curve = getattr(response, target.channel)
            batched = here.curves[batch][slot][row][: len(stimulus.time)]
            np.testing.assert_allclose(batched, curve, atol=1e-9)
            expected += np.sum((target.scale * (np.asarray(curve) - target.values)) ** 2 / target.thinning)
    np.testing.assert_allclose(np.sum(np.square(here.residuals)), expected, rtol=1e-9)
    assert problem.known().sum() == sum(len(target.values) for _, targets in pairs for target in targets)
    assert len(problem.known()) == len(here.residuals)


def test_the_jacobian_is_that_of_finite_differences(problem):
    hot, step = jnp.asarray(1.0), 1e-6
    here = sensitivity_at(problem, jnp.asarray(Z), hot)
    for i in range(len(FREE)):
        up, down = (sensitivity_at(problem, jnp.asarray(Z).at[i].add(sign * step), hot) for sign in (1, -1))
        slope = (up.residuals - down.residuals) / (2 * step)
        np.testing.assert_allclose(here.jacobian[:, i], slope, atol=2e-5 * float(jnp.abs(here.jacobian).max()))


def test_the_cell_is_searched_on_the_same_sums(problem):
    """The loss that the search reports is the loss of a whole evaluation at the point that it returns."""
    best = search_cell(problem, Z, sobol(5, 64, (1,)))
    loss = 0.5 * np.sum(np.square(problem.residuals(best.z, None)))
    np.testing.assert_allclose(best.loss, loss, rtol=1e-9)
    np.testing.assert_allclose(best.loss_before, 0.5 * np.sum(np.square(problem.residuals(Z, None))), rtol=1e-9)
    assert best.loss < best.loss_before
    pixels = list(problem.pixel_indices)
    np.testing.assert_array_equal(np.asarray(best.z)[pixels], Z[pixels])
    assert np.all((np.asarray(best.z) >= 0) & (np.asarray(best.z) <= 1))


def test_gain_and_baseline_are_solved_for():
    """With the right cell a search needs no luck for what the rate is linear in."""
    stimulus = loom(SMALL)
    rate = OBSERVATION(TRUTH(stimulus.frames, 30.0).smp_adapted, stimulus.time)
    pairs = [(stimulus, [lgmd.Target("rate", np.asarray(rate)).on(stimulus)])]
    free = Free(gain=(10, 200), baseline=(0, 20))
    problem = problem_of(TRUTH, lgmd.Observation(latency=40.0, smoothing=30.0), free, pairs, "squares")
    best = search_cell(problem, np.array([0.9, 0.9]), sobol(2, 4, (1,)))
    values = free.values(best.z)
    np.testing.assert_allclose([values["gain"], values["baseline"]], [80, 3], rtol=1e-6)
    tied = Free(gain=(10, 200), baseline=Tie("gain", 3 / 80))
    problem = problem_of(TRUTH, lgmd.Observation(latency=40.0, smoothing=30.0), tied, pairs, "squares")
    best = search_cell(problem, np.array([0.9]), sobol(1, 64, (1,)))
    np.testing.assert_allclose(tied.values(best.z)["gain"], 80, rtol=0.05)


def test_a_prior_keeps_its_width_when_chi2_is_divided_by_the_variance():
    stimulus = loom(SMALL)
    target = lgmd.Target("smp_adapted", np.full(len(stimulus.time), 0.6), error=0.1).on(stimulus)
    free = Free(k=(0.1, 2), T_ffi=(1, 40))
    with_prior = Free(k=Linear(0.1, 2, prior=(0.5, 0.2)), T_ffi=Linear(1, 40, prior=(20, 4)))
    z, variance = jnp.array([0.7, 0.3]), 9.0
    values = free.values(z)
    expected = ((values["k"] - 0.5) / 0.2) ** 2 + ((values["T_ffi"] - 20) / 4) ** 2
    chi2 = {}
    for kind in (free, with_prior):
        residuals = chi2_residuals(
            problem_of(TRUTH, OBSERVATION, kind, [(stimulus, [target])], "squares"), 0.5, variance
        )
        chi2[kind] = np.sum(np.square(residuals(z))) / variance
    np.testing.assert_allclose(chi2[with_prior] - chi2[free], expected, rtol=1e-9)


def test_the_error_of_a_frame_counts_its_neighbours():
    """Three frames that make one sample are each three times as uncertain in variance as one frame of its own."""
    stimulus, fast = loom(SMALL), loom(FAST)
    values, frame = np.full(len(stimulus.time), 0.6), 1000 / 30
    problem = problem_of(
        TRUTH,
        OBSERVATION,
        FREE,
        [
            (stimulus, [lgmd.Target("smp_adapted", values, error=0.1, correlation_ms=3 * frame).on(stimulus)]),
            (stimulus, [lgmd.Target("spikes", values, error=0.3).on(stimulus)]),
            (fast, [lgmd.Target("rate", np.full(len(fast.time), 9.0), error=5.0, correlation_ms=2 * frame).on(fast)]),
        ],
        "squares",
    )
    errors = problem.frame_errors(variance=4.0)
    assert errors == pytest.approx({"smp_adapted": 2 * 0.1 * 3**0.5, "spikes": 2 * 0.3, "rate": 2 * 5.0 * 2.0})


def test_the_error_of_a_frame_counts_the_frames_between_two_values():
    """A value every fourth frame tells a quarter of what one in each tells, however its neighbours hang on it."""
    stimulus, frame = loom(SMALL), 1000 / 30
    times = np.asarray(stimulus.time)[::4]

    def error(correlation_ms):
        target = lgmd.Target(
            "smp", np.full(len(times), 0.6), times, error=0.1, correlation_ms=correlation_ms, interpolate=True
        )
        problem = problem_of(TRUTH, OBSERVATION, FREE, [(stimulus, [target.on(stimulus)])], "squares")
        return problem.frame_errors(variance=1.0)["smp"]

    assert error(0.0) == pytest.approx(0.1 * 4**0.5)
    assert error(3 * frame) == pytest.approx(0.1 * 4**0.5)  # values of their own
    assert error(8 * frame) == pytest.approx(0.1 * 8**0.5)


def test_sobol_points_fill_the_box_and_follow_the_seed():
    points = sobol(3, 100, (4, 2))
    assert points.shape == (100, 3)
    np.testing.assert_allclose(points.mean(axis=0), 0.5, atol=0.02)
    np.testing.assert_array_equal(points, sobol(3, 100, (4, 2)))
    assert not np.array_equal(points, sobol(3, 100, (4, 3)))
    assert sobol(0, 100, (1,)).shape == (1, 0)
