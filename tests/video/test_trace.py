"""The table of a response."""

import numpy as np

from lgmd2jax._video.trace import Trace


def test_alarms_are_stretches():
    def trace(collision):
        frames, ones = np.arange(len(collision)), np.ones(len(collision))
        return Trace(frames, ones, ones, ones, ones, ones, frames, np.array(collision))

    assert trace([0, 0]).alarms() == []
    assert trace([1, 1]).alarms() == [(0, 1)]
    assert trace([0, 1, 0, 1, 1]).alarms() == [(1, 1), (3, 4)]
