"""Bands as targets: segments of time, edges at the frames, and what cannot be."""

import jax.numpy as jnp
import numpy as np
import pytest

from lgmd2jax._targets.band import Band
from lgmd2jax._targets.target import Target
from lgmd2jax._targets.weighted import Weighted
from lgmd2jax.stimuli import Stimulus

FRAMES = np.arange(-5, 6) * 10.0
STIMULUS = Stimulus(jnp.zeros((11, 3, 3)), 100.0, jnp.asarray(FRAMES))


def upper(target: Target) -> np.ndarray:
    assert target.upper is not None
    return target.upper


def test_one_segment_is_the_whole_stimulus():
    target = Band(low=0.5, high=np.inf, channel="smp", quote="quiet").on(STIMULUS)
    assert (target.channel, target.quote, target.is_band) == ("smp", "quiet", True)
    np.testing.assert_array_equal(target.values, np.full(11, 0.5))
    np.testing.assert_array_equal(upper(target), np.full(11, np.inf))
    np.testing.assert_array_equal(target.scale, np.ones(11))


def test_a_segment_ends_before_its_end_and_gaps_do_not_count():
    target = Band(segments_ms=[(-30, 0), (0, 20), (40, 90)], low=[0.5, 0.6, 0.5], high=[0.55, 0.9, 0.7]).on(STIMULUS)
    counted = target.scale > 0
    np.testing.assert_array_equal(FRAMES[counted], [-30, -20, -10, 0, 10, 40, 50])
    np.testing.assert_array_equal(target.values[counted], [0.5] * 3 + [0.6] * 2 + [0.5] * 2)
    np.testing.assert_array_equal(upper(target)[counted], [0.55] * 3 + [0.9] * 2 + [0.7] * 2)


def test_one_edge_may_be_the_same_in_all_segments():
    target = Band(segments_ms=[(-50, 0), (0, 60)], low=0.5, high=[0.6, 0.9]).on(STIMULUS)
    np.testing.assert_array_equal(target.values, np.full(11, 0.5))
    np.testing.assert_array_equal(upper(target), np.where(FRAMES < 0, 0.6, 0.9))


def test_error_and_window_are_those_of_any_target():
    target = Weighted(Band(low=0.5, high=0.6), error=0.1, from_ms=0).on(STIMULUS)
    np.testing.assert_array_equal(target.scale, np.where(FRAMES >= 0, 10.0, 0.0))
    assert target.has_error


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"low": 0.7}, "low is 0.7 and high 0.6 in segment 1; swap them"),
        ({"low": -np.inf, "high": np.inf}, "low is -inf and high inf in segment 1; give a finite edge"),
        ({"low": np.inf, "high": np.inf}, "give a finite edge"),
        ({"low": np.nan}, "low holds nan; give numbers"),
        ({"low": ["a"]}, r"low\[0\] is 'a'; give a number"),
        ({"low": [0.5, 0.5]}, "low has 2 values and there are 1 segments; give one for each"),
        ({"segments_ms": [(0, 9), (20, 29)], "high": [0.6, 0.4]}, "low is 0.5 and high 0.4 in segment 2"),
        ({"segments_ms": [(0, 0)]}, r"segments_ms is \[\(0, 0\)\]; give \[start, end\] of each in ms"),
        ({"segments_ms": [(0, 20), (10, 30)]}, "one after the other"),
        ({"segments_ms": [(0, 20, 30)]}, "segments_ms is"),
        ({"segments_ms": []}, r"segments_ms is \[\]; give"),
        ({"segments_ms": [(np.nan, 2)]}, "segments_ms is"),
        ({"channel": "mp"}, "channel is 'mp'; choose"),
    ],
)
def test_what_cannot_be_is_refused(change, message, untyped):
    with pytest.raises(ValueError, match=message):
        Band(**{"low": 0.5, "high": 0.6} | change)


def test_every_segment_holds_a_frame():
    with pytest.raises(ValueError, match="segment from 60 to 90 ms holds no frame; the stimulus covers -50 to 50 ms"):
        Band(low=0.5, high=0.6, segments_ms=[(0, 60), (60, 90)]).on(STIMULUS)


# As arrays


def test_edges_move_onto_the_frames():
    """Linearly; between a finite and an infinite edge the side stays open."""
    time, low, high = (
        np.array([-50.0, -25, 0, 50]),
        np.array([0.5, 0.5, 0.6, 0.8]),
        np.array([0.6, 0.7, np.inf, np.inf]),
    )
    target = Target("smp", low, time=time, upper=high, interpolate=True).on(STIMULUS)
    np.testing.assert_allclose(target.values[target.weight > 0], np.interp(FRAMES, time, low)[target.weight > 0])
    expected = np.where(FRAMES <= -25, 0.6 + 0.1 * (FRAMES + 50) / 25, np.inf)
    np.testing.assert_allclose(upper(target), expected)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"upper": np.full(11, 0.4)}, "lower edge is 0.5 where the upper one is 0.4; swap them"),
        ({"values": np.full(11, -np.inf), "upper": np.full(11, np.inf)}, "a band has no finite edge"),
        ({"upper": np.full(10, 0.6)}, r"upper has shape \(10,\) and values \(11,\)"),
        ({"upper": np.full(11, np.nan)}, r"upper\[0\] is nan; give a finite number"),
        ({"upper": np.full(11, 0.6), "sem": np.ones(11)}, "a band has a sem, which only a curve has; give an error"),
        ({"values": np.full(11, -np.inf)}, r"values\[0\] is -inf; give a finite number"),
    ],
)
def test_arrays_that_are_no_band_are_refused(settings, message, untyped):
    with pytest.raises(ValueError, match=message):
        Target("smp", **{"values": np.full(11, 0.5)} | settings)
