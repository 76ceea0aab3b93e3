"""Snapshots of a clip whose length is not known."""

import numpy as np

from lgmd2jax._video.snapshots import Snapshots


def test_snapshots_spread_evenly_whatever_the_length():
    picture = np.zeros((6, 500, 3), np.uint8)
    for count in (1, 2, 7, 8, 9, 40, 1000, 1017):
        snapshots = Snapshots()
        for i in range(count):
            snapshots.offer(i, i * 10.0, False, lambda: picture)
        chosen = [shot.frame for shot in snapshots.chosen()]
        assert len(chosen) == min(count, 8)
        assert chosen[0] == 0
        if count > 8:
            gaps = np.diff(chosen)
            assert gaps.min() >= 0.5 * gaps.max()
            assert count - chosen[-1] <= gaps.max()
    assert snapshots.chosen()[0].picture.shape[1] <= 250


def test_the_first_alarm_is_among_the_snapshots():
    snapshots = Snapshots()
    for i in range(100):
        snapshots.offer(i, i * 10.0, i in (61, 62, 90), lambda: np.zeros((6, 6, 3), np.uint8))
    assert [shot.frame for shot in snapshots.chosen() if shot.alarm] == [61]
    assert len(snapshots.chosen()) == 8
