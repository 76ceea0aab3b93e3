"""The response of another model as a target."""

import dataclasses

import jax
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax._targets.model_target import ModelTarget
from lgmd2jax._targets.observation import Observation

EYE = lgmd.Eye(rows=8, cols=10, degrees_per_pixel=10.0, fps=50.0)
KEY = jax.random.key(3)


@pytest.fixture(scope="module")
def stimulus():
    return lgmd.stimuli.looming(EYE, l_over_v=40.0, contrast=-0.9, start_ms=-400.0, end_ms=100.0)


@pytest.mark.parametrize("channel", ["smp", "smp_adapted", "spikes"])
@pytest.mark.parametrize("thresholds", [lgmd.Hard(), lgmd.Soft(0.5)])
def test_it_is_the_response(stimulus, channel, thresholds):
    model = lgmd.LGMD2(lgmd.Parameters(k=0.3), thresholds)
    target = ModelTarget(model=model, channel=channel).on(stimulus)
    np.testing.assert_array_equal(target.values, getattr(model(stimulus.frames, 50.0), channel))
    assert np.ptp(target.values) > 0.1
    assert not target.has_error


def test_a_rate_goes_through_the_observation(stimulus):
    observation = Observation(baseline=4.0, latency=33.0)
    target = ModelTarget(model=lgmd.LGMD2(), channel="rate", observation=observation).on(stimulus)
    expected = observation(lgmd.LGMD2()(stimulus.frames, 50.0).smp_adapted, stimulus.time)
    np.testing.assert_array_equal(target.values, expected)


def test_noise_is_normal_known_and_repeatable():
    stimulus = lgmd.stimuli.looming(EYE, l_over_v=40.0, contrast=-0.9, start_ms=-39_000.0, end_ms=1000.0)
    clean = ModelTarget(model=lgmd.LGMD2()).on(stimulus).values
    noisy = ModelTarget(model=lgmd.LGMD2(), noise=0.02, key=KEY)
    noise = noisy.on(stimulus).values - clean
    # 2001 draws: the mean is known to .00045, the deviation to .0003, the correlation of neighbours to .022.
    assert abs(noise.mean()) < 4 * 0.02 / np.sqrt(2001)
    assert abs(noise.std() - 0.02) < 4 * 0.02 / np.sqrt(2 * 2001)
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 4 / np.sqrt(2001)
    np.testing.assert_array_equal(noisy.on(stimulus).scale, 50.0)
    np.testing.assert_array_equal(noisy.on(stimulus).values, clean + noise)


def test_conditions_and_channels_have_noise_of_their_own():
    stimulus = lgmd.stimuli.looming(EYE, l_over_v=40.0, contrast=-0.9, start_ms=-39_000.0, end_ms=1000.0)

    def noise(channel, name):
        shown = dataclasses.replace(stimulus, name=name)
        clean, noisy = (
            ModelTarget(model=lgmd.LGMD2(), channel=channel, noise=strength, key=KEY).on(shown).values
            for strength in (0.0, 0.1)
        )
        return noisy - clean

    one, other, third = noise("smp", "a"), noise("smp", "b"), noise("smp_adapted", "a")
    for pair in ((one, other), (one, third), (other, third)):
        assert abs(np.corrcoef(*pair)[0, 1]) < 4 / np.sqrt(2001)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"channel": "mp"}, "channel is 'mp'; choose 'smp'"),
        ({"channel": "rate"}, "channel is 'rate', which needs an observation"),
        ({"observation": Observation()}, "channel is 'smp_adapted', which takes no observation"),
        ({"noise": -1}, "noise is -1; give 0 or more"),
        ({"noise": np.nan}, "noise is nan"),
        ({"noise": 0.1}, "noise is 0.1 without a key; give key="),
    ],
)
def test_what_cannot_be_is_refused(change, message, untyped):
    with pytest.raises(ValueError, match=message):
        ModelTarget(**{"model": lgmd.LGMD2()} | change)
