"""The observation model: a late, smoothed, scaled potential, and its slopes."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from lgmd2jax._targets.observation import Observation, observation_symbols

TIME = np.arange(-40, 60) * 10.0
NAMES = ["baseline", "gain", "latency", "smoothing"]


def bump(time):
    """A potential that rises and falls, at any time."""
    return 0.5 + 0.3 * np.exp(-((time / 90) ** 2))


def test_it_is_a_shift_a_scale_and_a_gaussian():
    time = np.arange(200) * 5.0
    potential = 0.5 + 0.3 * np.exp(-(((time - 400) / 60) ** 2))
    rate = Observation(baseline=3.0, gain=50.0, latency=35.0, smoothing=20.0)(potential, time)
    smooth = gaussian_filter1d(np.roll(potential, 7), 4.0, mode="nearest", truncate=8)
    np.testing.assert_allclose(rate, 3 + 50 * 2 * (smooth - 0.5), atol=1e-3)


@pytest.mark.parametrize("latency", [0.0, 2.5, 10.0, 13.7, 77.7])
def test_latency_interpolates_between_frames(latency):
    """Linear pieces err by h2/8 times the curvature; whole frames are exact."""
    rate = np.asarray(Observation(gain=0.5, latency=latency, smoothing=1e-3)(bump(TIME), TIME))
    expected = bump(TIME - latency) - 0.5
    bound = 10**2 / 8 * 0.3 * 2 / 90**2
    assert np.max(np.abs(rate - expected)[20:]) < (1e-12 if latency % 10 == 0 else bound)
    earlier, later = (bump(TIME - latency // 10 * 10 - shift) - 0.5 for shift in (0, 10))
    share = latency % 10 / 10
    np.testing.assert_allclose(rate[20:], ((1 - share) * earlier + share * later)[20:], atol=1e-12)


def test_before_the_first_frame_is_rest():
    rate = Observation(baseline=4.0, gain=50.0, latency=200.0, smoothing=1e-3)(np.full(100, 0.9), TIME)
    np.testing.assert_allclose(rate[:20], 4.0, atol=1e-12)
    np.testing.assert_allclose(rate[20:], 4.0 + 50 * 0.8, atol=1e-12)


def test_the_rate_has_no_jump_as_the_latency_passes_a_frame():
    def rate(latency):
        return Observation(latency=latency, smoothing=1e-3)(np.full(100, 0.9), TIME)

    np.testing.assert_allclose(rate(20 - 1e-9), rate(20 + 1e-9), atol=1e-6)


@pytest.mark.parametrize("smoothing", [5.0, 20.0, 100.0])
def test_a_constant_rate_stays_constant_up_to_the_ends(smoothing):
    rate = Observation(baseline=2.0, gain=100.0, smoothing=smoothing)(np.full(100, 0.7), TIME)
    np.testing.assert_allclose(rate, 42.0, rtol=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_slopes_are_those_of_finite_differences(name):
    at = {"baseline": 3.0, "gain": 70.0, "latency": 33.3, "smoothing": 25.0}
    potential = jnp.asarray(bump(TIME))

    def rate(value):
        return Observation(**{**at, name: value})(potential, TIME)

    step = 1e-4
    expected = (rate(at[name] + step) - rate(at[name] - step)) / (2 * step)
    assert np.max(np.abs(expected)) > 1e-2
    np.testing.assert_allclose(jax.jacfwd(rate)(at[name]), expected, atol=1e-6)
    np.testing.assert_allclose(jax.jacrev(rate)(at[name]), expected, atol=1e-6)


def test_slope_in_the_potential_is_the_kernel():
    slope = jax.jacfwd(lambda u: Observation(gain=30.0, latency=20.0)(u, TIME))(jnp.asarray(bump(TIME)))
    # Rows sum to gain 2 where all that is seen lies within the clip.
    np.testing.assert_allclose(slope.sum(1)[30:], 60.0, rtol=1e-9)
    assert np.all(np.asarray(slope)[:, -2:] == 0)


def test_a_batch_is_a_loop():
    rng = np.random.default_rng(0)
    values = {"baseline": rng.uniform(0, 9, 4), "gain": rng.uniform(9, 90, 4)}
    values |= {"latency": rng.uniform(0, 99, 4), "smoothing": rng.uniform(5, 50, 4)}
    batch = jax.vmap(lambda values: Observation(**values)(bump(TIME), TIME))(
        {name: jnp.asarray(value) for name, value in values.items()}
    )
    for lane in range(4):
        alone = Observation(**{name: value[lane] for name, value in values.items()})(bump(TIME), TIME)
        np.testing.assert_allclose(batch[lane], alone, rtol=1e-12)
    together = eqx.filter_vmap(lambda observation: observation(bump(TIME), TIME))(
        jax.vmap(lambda values: Observation(**values))({k: jnp.asarray(v) for k, v in values.items()})
    )
    np.testing.assert_allclose(together, batch, rtol=1e-12)


def test_values_do_not_compile_again():
    traces = []

    @eqx.filter_jit
    def rate(observation):
        traces.append(1)
        return observation(bump(TIME), TIME)

    for gain in (1, 2.0, np.float64(3)):
        rate(Observation(gain=gain))
    assert len(traces) == 1


def test_every_field_says_what_it_is():
    assert list(observation_symbols()) == NAMES
    for name, symbol in observation_symbols().items():
        low, high = symbol.bounds
        assert symbol.contains(low)
        assert symbol.contains(high)
        assert low <= getattr(Observation(), name) <= high
        assert symbol.meaning
        assert symbol.source
    assert {name for name, symbol in observation_symbols().items() if symbol.scale == "log"} == {"gain", "smoothing"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"gain": 0.0}, r"gain is 0 spikes/s; it must lie in \(0, inf\) spikes/s"),
        ({"smoothing": -1}, r"smoothing is -1 ms; it must lie in \(0, inf\)"),
        ({"latency": -0.1}, "latency is -0.1 ms"),
        ({"baseline": np.nan}, "baseline is nan"),
        ({"gain": np.inf}, "gain is inf"),
        ({"gain": "much"}, "gain is 'much'; give a number"),
        ({"latency": None}, "latency is None; give a number"),
    ],
)
def test_what_cannot_be_is_refused(change, message, untyped):
    with pytest.raises(ValueError, match=message):
        Observation(**change)
