"""The likelihood of spike counts against scipy's, and intervals against simulated trains."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy

import lgmd2jax as lgmd
from lgmd2jax.fitting._conditions import render
from lgmd2jax.fitting._curve import curve_of
from lgmd2jax.fitting._poisson import bin_means, deviance_residuals
from lgmd2jax.fitting._problem import chi2_residuals, problem_of
from lgmd2jax.fitting._uncertainty.covariance import linearised_uncertainty
from lgmd2jax.fitting._uncertainty.jacobian import known_rows, sensitivity_at
from lgmd2jax.fitting._uncertainty.profile import refit

EYE = lgmd.Eye(rows=8, cols=10, degrees_per_pixel=8.0, fps=60.0)
MODEL = lgmd.LGMD2(lgmd.Parameters(T_s=5.0, T_sfa=5e-4, tau2=300.0, k=0.4), lgmd.Soft(1.0), eye=EYE)
TRUTH = lgmd.Observation(baseline=6.0, gain=120.0, latency=25.0, smoothing=15.0)
FREE = lgmd.Free(gain=None, baseline=None, latency=None)
TRIALS, SETS = 6, 60


@pytest.fixture(scope="module")
def stimulus():
    return lgmd.stimuli.looming(EYE, l_over_v=40.0, contrast=-0.9, start_ms=-700.0, end_ms=300.0)


@pytest.fixture(scope="module")
def rate(stimulus):
    return np.asarray(TRUTH(MODEL(stimulus.frames, stimulus.fps).smp_adapted, stimulus.time))


def trains(rate, time, seed):
    """Spikes of an inhomogeneous Poisson process by thinning (Lewis & Shedler, 1979)."""
    generator = np.random.default_rng(seed)
    start, end, most = time[0] - 8, time[-1] + 8, 1.01 * rate.max()
    spikes = [
        np.sort(generator.uniform(start, end, generator.poisson(most * (end - start) / 1000))) for _ in range(TRIALS)
    ]
    kept = [generator.uniform(0, most, len(train)) < np.interp(train, time, rate) for train in spikes]
    return lgmd.SpikeTrains([[t[k] for t, k in zip(spikes, kept, strict=True)]], likelihood="poisson")


def mean_rates(rate, time):
    """The mean over each bin, by the trapezoidal rule on its halves, in which the rate is linear."""
    half, ends = np.diff(time).mean() / 2, (rate[0], rate[-1])
    between = scipy.interpolate.interp1d(time, rate, axis=0, bounds_error=False, fill_value=ends)
    return (between(time - half) + 2 * between(time) + between(time + half)) / 4


@pytest.fixture(scope="module")
def problem(stimulus, rate):
    pairs = render([(stimulus, trains(rate, np.asarray(stimulus.time), 0))])
    return problem_of(MODEL, TRUTH, FREE, pairs, "squares")


def test_squares_of_deviance_residuals_are_the_likelihood_ratio():
    counts = np.array([0.0, 0, 1, 3, 3, 3, 10, 200])
    means = np.array([0.01, 2, 0.02, 3, 3.0001, 2.5, 25, 199])
    found = deviance_residuals(jnp.asarray(counts), jnp.asarray(means))
    ratio = 2 * (scipy.stats.poisson.logpmf(counts, counts) - scipy.stats.poisson.logpmf(counts, means))
    np.testing.assert_allclose(np.square(found), ratio, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(np.sign(found), np.sign(means - counts))
    slopes = jax.vmap(jax.grad(lambda n, mu: jnp.square(deviance_residuals(n, mu)), argnums=1))(
        jnp.asarray(counts), jnp.asarray(means)
    )
    np.testing.assert_allclose(slopes, 2 * (1 - counts / means), rtol=1e-9, atol=1e-12)
    at_mean = jax.grad(lambda mu: deviance_residuals(jnp.asarray(4.0), mu))(4.0)
    assert at_mean == pytest.approx(0.5)


def test_counts_are_those_of_bins_around_the_frames(stimulus):
    time = np.asarray(stimulus.time)
    middle = (time[3] + time[4]) / 2
    spikes = lgmd.SpikeTrains([[[middle - 0.1, middle + 0.1], [middle + 0.2]], [[time[7]]]], likelihood="poisson")
    target = spikes.on(stimulus)
    assert target.exposure is not None
    np.testing.assert_allclose(target.exposure, 3 / 60)
    counts = target.values * target.exposure
    assert (counts[3], counts[4], counts[7], counts.sum()) == pytest.approx((1, 2, 1, 4))
    assert spikes.of("2").trials == [[[time[7]]]]


def test_a_bin_counts_the_integral_of_the_rate(stimulus, rate):
    time, everywhere = np.asarray(stimulus.time), jnp.ones(len(rate), bool)
    np.testing.assert_allclose(bin_means(jnp.asarray(rate), everywhere), mean_rates(rate, time), rtol=1e-9)
    slopes = np.stack([rate, rate**2], axis=1)
    np.testing.assert_allclose(bin_means(jnp.asarray(slopes), everywhere), mean_rates(slopes, time), rtol=1e-9)
    # What lies beyond the counted frames, such as those that fill up a batch, has no part in it.
    longer, counted = jnp.append(jnp.asarray(rate), jnp.full(3, 1e9)), jnp.append(everywhere, jnp.zeros(3, bool))
    np.testing.assert_allclose(bin_means(longer, counted)[:-3], mean_rates(rate, time), rtol=1e-9)


def test_information_is_fishers_and_the_likelihood_scipys(problem, stimulus):
    z = jnp.asarray(FREE.place(MODEL.parameters, TRUTH))
    slopes = sensitivity_at(problem, z, jnp.asarray(1.0))
    jacobian, residuals = known_rows(problem, slopes)
    slot, time = problem.batches[0].slots[0], np.asarray(stimulus.time)
    rates, by_z = (mean_rates(np.asarray(rows[0][0][0]), time) for rows in (slopes.curves, slopes.slopes))
    exposure = np.asarray(slot.exposure[0])
    np.testing.assert_allclose(jacobian.T @ jacobian, by_z.T @ np.diag(exposure / rates) @ by_z, rtol=1e-9)
    counts, means = np.asarray(slot.low[0]) * exposure, rates * exposure
    expected = -2 * scipy.stats.poisson.logpmf(np.rint(counts), means).sum()
    assert problem.minus_two_log_likelihood(slopes.curves) == pytest.approx(expected, rel=1e-9)
    half_deviance = np.asarray(slopes.jacobian).T @ np.asarray(slopes.residuals)
    np.testing.assert_allclose(jacobian.T @ residuals, half_deviance, rtol=1e-7)  # one slope, of one likelihood


def test_intervals_hold_the_truth(problem, stimulus, rate):
    """A case of `python -m benchmarks.coverage`, small: the truth lies as far off as standard errors say."""
    truth, time = FREE.place(MODEL.parameters, TRUTH), np.asarray(stimulus.time)
    off = []
    for seed in range(SETS):
        target = trains(rate, time, seed).on(stimulus)
        own = problem_of(MODEL, TRUTH, FREE, [(stimulus, [target])], "squares")
        nothing = jnp.asarray(-1), jnp.asarray(0.0)
        z = np.asarray(refit(chi2_residuals(own, 1.0, 1.0), jnp.asarray(truth), *nothing, 50)[0])
        rows, residuals = known_rows(own, sensitivity_at(own, jnp.asarray(z), jnp.asarray(1.0)))
        u = linearised_uncertainty(
            FREE.names, z, FREE.unpacked, FREE.slopes(z), rows, residuals, n_effective=60, absolute=True
        )
        off.append((z - truth) / np.sqrt(np.diag(u.covariance_z)))
    off = np.array(off)
    held = np.mean(np.abs(off) < 1.96)
    assert 0.90 < held < 0.99
    np.testing.assert_allclose(np.square(off).mean(), 1, atol=0.35)


def test_intervals_end_where_the_likelihood_has_fallen(stimulus, rate):
    """Found again by scipy, which fits the other parameters anew while the latency stands at an end."""
    pair = stimulus, trains(rate, np.asarray(stimulus.time), 3)
    fit = lgmd.fit(
        MODEL, [pair], FREE, key=jax.random.key(0), observation=TRUTH, pixel_points=1, cell_points=8, descend=1
    )
    target, potential = pair[1].on(stimulus), MODEL(stimulus.frames, stimulus.fps).smp_adapted
    n, time = target.values * target.exposure, np.asarray(stimulus.time)

    @jax.jit
    def rates(values):
        observation = lgmd.Observation(gain=values[0], baseline=values[1], latency=values[2], smoothing=15.0)
        return observation(potential, stimulus.time)

    def minus_two_log_likelihood(values):
        return (
            -2
            * scipy.stats.poisson.logpmf(
                np.rint(n), mean_rates(np.asarray(rates(values)), time) * target.exposure
            ).sum()
        )

    best, index = np.array([fit.values[name] for name in FREE.names]), FREE.names.index("latency")

    def of_others(others, latency):
        return minus_two_log_likelihood(np.insert(others, index, latency))

    for end in fit.uncertainty.intervals[index]:
        found = scipy.optimize.minimize(of_others, np.delete(best, index), (end,), "Nelder-Mead", tol=0.01)
        assert found.fun - minus_two_log_likelihood(best) == pytest.approx(3.84, abs=0.05)
    assert fit.nonlinear == ()


def test_a_curve_of_counts_has_its_deviance_and_grade(stimulus, rate):
    pair = render([(stimulus, trains(rate, np.asarray(stimulus.time), 0))])[0]
    target, flat = pair.targets[0], np.full(len(rate), rate.mean())
    curve = curve_of(stimulus, target, rate, rate, 0 * rate, 6.0)
    counts, means = target.values * target.exposure, mean_rates(rate, np.asarray(stimulus.time)) * target.exposure
    ratio = 2 * (scipy.special.xlogy(counts, counts / means) - counts + means)
    assert curve.chi2() == pytest.approx(ratio.sum())
    assert curve.grade == "good"
    assert dataclasses.replace(curve, hard=flat).grade == "missed"
    assert curve.minus_two_log_likelihood() == pytest.approx(
        -2 * scipy.stats.poisson.logpmf(np.rint(counts), means).sum()
    )


def test_misuse_is_refused(untyped):
    with pytest.raises(ValueError, match="likelihood is 'poison'; choose 'poisson'"):
        lgmd.SpikeTrains([[[1.0]]], likelihood="poison")  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="give 2 different names"):
        lgmd.SpikeTrains([[[1.0]], [[2.0]]], animals=["a", "a"])
    with pytest.raises(ValueError, match=r"exposure\[0\] is 0; give a positive number of seconds"):
        lgmd.Target("rate", [1.0], exposure=[0.0])
    with pytest.raises(ValueError, match="exposure is for counts of spikes"):
        lgmd.Target("smp", [1.0], exposure=[0.1])
