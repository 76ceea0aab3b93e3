"""The evidence for an alarm, against spikes that are counted one by one."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from lgmd2jax.alarms import evidence


def alarms(u, T_sp, sigma_sp, N_sp, N_ts):
    """Eqs 16 and 17 as they are written, frame by frame."""
    spikes = [0 if level < T_sp else 1 if level <= T_sp + sigma_sp else 2 for level in u]
    return np.array([sum(spikes[max(0, t - N_ts) : t + 1]) >= N_sp for t in range(len(u))])


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.sampled_from([(4, 8), (0, 3), (2, 12)]))
def test_the_alarm_is_on_exactly_where_the_evidence_reaches_the_threshold(seed, N_sp, shape):
    N_ts, frames = shape
    chance = np.random.default_rng(seed)
    u, sigma_sp = chance.uniform(0.5, 1, frames), chance.uniform(0.02, 0.3)
    highest = np.asarray(evidence(u, sigma_sp, N_sp, N_ts))
    for T_sp in chance.uniform(0.3, 1, 40):
        np.testing.assert_array_equal(highest >= T_sp, alarms(u, T_sp, sigma_sp, N_sp, N_ts))


def test_more_spikes_than_the_window_can_hold_never_alarm():
    assert not np.asarray(evidence(np.full(9, 0.99), 0.0, 11, 4)).any()
    assert np.asarray(evidence(np.full(9, 0.99), 0.0, 10, 4))[4:] == pytest.approx(0.99)
