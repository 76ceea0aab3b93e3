"""The simulator against single calls of the model, in the shapes and kinds that tools of inference want."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd

EYE = lgmd.Eye(rows=8, cols=10, degrees_per_pixel=8.0, fps=60.0)
MODEL = lgmd.LGMD2(lgmd.Parameters(T_s=5.0, T_sfa=5e-4, tau2=300.0), lgmd.Soft(1.0), eye=EYE)
FREE = lgmd.Free(k=lgmd.Log(0.2, 2), gain=(50, 200))
OBSERVATION = lgmd.Observation(baseline=5.0, latency=25.0)
LOOMS = [
    lgmd.stimuli.looming(EYE, l_over_v=l_over_v, contrast=-0.9, start_ms=-8 * l_over_v, end_ms=200.0)
    for l_over_v in (20.0, 40.0)
]
THETA = np.array([[0.4, 100.0], [1.0, 60.0], [0.3, 150.0]])


@pytest.fixture(scope="module")
def simulator():
    return lgmd.as_simulator(MODEL, LOOMS, FREE, observation=OBSERVATION)


def rates(theta):
    model = lgmd.LGMD2(lgmd.Parameters(T_s=5.0, T_sfa=5e-4, tau2=300.0, k=theta[0]), lgmd.Soft(1.0), eye=EYE)
    observation = lgmd.Observation(baseline=5.0, latency=25.0, gain=theta[1])
    return [np.asarray(observation(model(loom.frames, loom.fps).smp_adapted, loom.time)) for loom in LOOMS]


def test_summaries_are_those_of_single_calls(simulator):
    found = simulator(THETA)
    assert isinstance(found, np.ndarray)
    assert found.shape == (3, 6)
    for theta, row in zip(THETA, found, strict=True):
        for loom, rate, (mean, peak, time) in zip(LOOMS, rates(theta), row.reshape(2, 3), strict=True):
            np.testing.assert_allclose([mean, peak], [rate.mean(), rate.max()], rtol=1e-9)
            assert abs(time - loom.time[np.argmax(rate)]) <= 0.5 * 1000 / 60 + 1e-9


def test_kinds_and_shapes(simulator):
    as_jax = simulator(jnp.asarray(THETA))
    assert isinstance(as_jax, jax.Array)
    np.testing.assert_allclose(as_jax, simulator(THETA), rtol=1e-12)
    np.testing.assert_allclose(simulator(THETA[0]), simulator(THETA)[0], rtol=1e-12)
    assert (simulator.names, simulator.units) == (("k", "gain"), ("grey level", "spikes/s"))
    np.testing.assert_array_equal([simulator.low, simulator.high], [[0.2, 50], [2, 200]])
    prior = np.asarray(simulator.prior(jax.random.key(0), 2000))
    assert ((simulator.low <= prior) & (prior <= simulator.high)).all()
    np.testing.assert_allclose(np.median(prior, axis=0), [np.sqrt(0.4), 125], rtol=0.05)


def test_the_slope_is_that_of_differences(simulator):
    def peak(gain):
        return simulator(jnp.stack([jnp.asarray(0.4), gain]))[1]

    gain = jnp.asarray(100.0)
    np.testing.assert_allclose(jax.jacfwd(peak)(gain), (peak(gain + 1) - peak(gain - 1)) / 2, rtol=1e-6)


def test_noise_is_that_of_so_many_trials():
    """Its mean is the answer without noise, its variance that of counts."""
    recorded = lgmd.as_simulator(MODEL, LOOMS, FREE, observation=OBSERVATION, trials=40)
    noisy, clean = recorded(np.tile(THETA[:1], (300, 1)), jax.random.key(0)), recorded(THETA[0])
    assert np.unique(noisy[:, 0]).size > 290
    for number, rate in enumerate(rates(THETA[0])):
        mean = noisy[:, 3 * number]
        exposure = 40 * len(rate) / 60
        error = np.sqrt(rate.mean() / exposure)
        assert abs(mean.mean() - clean[3 * number]) < 4 * error / np.sqrt(300) + 0.01 * clean[3 * number]
        assert np.std(mean) == pytest.approx(error, rel=0.2)


def test_summaries_of_ones_own():
    own = lgmd.as_simulator(MODEL, LOOMS[:1], FREE, observation=OBSERVATION, summaries=lambda time, rate: rate[-2:])
    np.testing.assert_allclose(own(THETA[0]), rates(THETA[0])[0][-2:], rtol=1e-9)


def test_misuse_is_refused(simulator, untyped):
    with pytest.raises(ValueError, match=r"theta has shape \(3,\); give \(batch, 2\): k, gain"):
        simulator(np.zeros(3))
    with pytest.raises(ValueError, match="the simulator has no noise"):
        lgmd.as_simulator(MODEL, LOOMS, FREE)(THETA, jax.random.key(0))
    with pytest.raises(ValueError, match="summaries is 'curve'; give a function or 'curves'"):
        lgmd.as_simulator(MODEL, LOOMS, FREE, summaries="curve")  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="conditions is empty"):
        lgmd.as_simulator(MODEL, [], FREE)
    with pytest.raises(ValueError, match="trials is for the channel 'rate'"):
        lgmd.as_simulator(MODEL, LOOMS, FREE, trials=3, noise=1.0)
