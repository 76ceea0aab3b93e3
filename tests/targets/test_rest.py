"""Rest and brief onsets as targets."""

import jax.numpy as jnp
import numpy as np
import pytest

from lgmd2jax._targets.rest import Onset, Rest
from lgmd2jax.stimuli import Stimulus

FRAMES = np.arange(-5, 6) * 10.0
STIMULUS = Stimulus(jnp.zeros((11, 3, 3)), 100.0, jnp.asarray(FRAMES))


@pytest.mark.parametrize(
    ("channel", "rest", "value"),
    [("smp", None, 0.5), ("smp_adapted", None, 0.5), ("spikes", None, 0), ("rate", 3.0, 3), ("smp", 0.6, 0.6)],
)
def test_rest_is_that_of_the_channel(channel, rest, value):
    target = Rest(channel=channel, rest=rest).on(STIMULUS)
    assert target.channel == channel
    np.testing.assert_array_equal(target.values, np.full(11, value))


def test_an_onset_decays_by_e_within_its_time_constant():
    values = Onset(peak=0.4, decay_ms=20.0, at_ms=-10).on(STIMULUS).values
    np.testing.assert_array_equal(values[:4], 0.5)
    assert values[4] == 0.9
    np.testing.assert_allclose((values[4:-2] - 0.5) / (values[6:] - 0.5), np.e, rtol=1e-12)


def test_an_onset_between_frames_is_seen_at_the_next():
    values = Onset(peak=1.0, decay_ms=20.0, at_ms=5, channel="spikes").on(STIMULUS).values
    np.testing.assert_allclose(values[5:7], [0, np.exp(-5 / 20)])


@pytest.mark.parametrize(
    ("kind", "change", "message"),
    [
        (Rest, {"channel": "rates"}, "channel is 'rates'; choose 'rate'"),
        (Rest, {"channel": "rate"}, "rest is missing; a rate has no resting value of its own"),
        (Onset, {"peak": np.nan, "decay_ms": 1}, "peak is nan"),
        (Onset, {"peak": 1, "decay_ms": 0}, "decay_ms is 0 ms; give a positive number"),
        (Onset, {"peak": 1, "decay_ms": np.inf}, "decay_ms is inf"),
        (Onset, {"peak": 1, "decay_ms": 9, "at_ms": np.nan}, "at_ms is nan"),
        (Onset, {"peak": 1, "decay_ms": 9, "channel": "rate"}, "rest is missing"),
    ],
)
def test_what_cannot_be_is_refused(kind, change, message, untyped):
    with pytest.raises(ValueError, match=message):
        kind(**change)


def test_an_onset_lies_within_the_stimulus():
    with pytest.raises(ValueError, match="at_ms is 51, outside of the stimulus, which covers -50 to 50 ms"):
        Onset(peak=1, decay_ms=9, at_ms=51).on(STIMULUS)
