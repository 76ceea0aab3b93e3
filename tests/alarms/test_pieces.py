"""Long clips in pieces: every label is in one of them, none is cut, and the network is led to each."""

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.alarms import LabelledClip, evaluate
from lgmd2jax.alarms._pieces import pieces
from lgmd2jax.alarms._problem import problem_of
from tests.clips import patchy

FPS, COUNT = 20, 620  # 31 s
WINDOWS, SILENT = [(240, 262), (400, 402)], [(10, 200), (300, 399), (405, 619)]


@pytest.fixture(scope="module")
def clip():
    frames = patchy(0, (COUNT, 5, 6))
    return LabelledClip.of("c", frames, FPS, windows=WINDOWS, silent=SILENT, source="s", weight=2)


def test_every_label_is_in_one_piece(clip):
    parts = list(pieces(clip))
    assert len(parts) == 6  # of about 5 s
    assert sorted(window for part in parts for window in part.windows) == WINDOWS
    judged = [np.zeros(COUNT, bool) for _ in parts]
    for part, own in zip(parts, judged, strict=True):
        own[part.index[part.in_silence()]] = True
        np.testing.assert_array_equal(part.frames, clip.frames[part.index])
        np.testing.assert_array_equal(part.time, clip.time[part.index])
        assert (part.source, part.weight) == ("s", 2)
    np.testing.assert_array_equal(np.sum(judged, axis=0), clip.in_silence())


def test_frames_lead_to_a_piece(clip):
    """Two seconds of them, in which nothing is judged."""
    first, *others = pieces(clip)
    assert first.index[0] == 0
    for part in others:
        judged = part.in_silence() | part.in_windows().any(axis=0)
        assert np.flatnonzero(judged)[0] >= 2 * FPS


def test_a_short_clip_is_whole(clip):
    short = LabelledClip.of("c", clip.frames[:140], FPS, silent=[(10, 139)])
    (whole,) = pieces(short)
    for name, value in vars(short).items():
        np.testing.assert_array_equal(getattr(whole, name), value)


def test_a_long_silence_counts_for_more_and_weights_as_told(clip):
    model = lgmd.LGMD2(lgmd.preset("lgmd2", N_sp=4.0))
    free = lgmd.Free(k=(0.1, 2), T_sp=(0.51, 0.95))
    clips = [clip, *lgmd.alarms.Rendering(2, seed=3).clips(lgmd.Eye(12, 18, 4.0, 30.0, "pinhole"))]
    events = problem_of(model, free, clips, 3.0, 1.0).events
    own = [event for event in events if event.clip == 0]
    assert [event.weight for event in own if event.wanted] == [6.0, 6.0]
    silent = [event.weight for event in own if not event.wanted]
    assert silent == [2.0] * sum(bool(part.silent) for part in pieces(clip))
    assert len(silent) >= 5
    balanced = problem_of(model, free, clips, 3.0, 1.0, 0.5).events
    weighs = [sum(event.weight for event in balanced if (event.clip == 0) == of_own) for of_own in (True, False)]
    assert weighs[0] == pytest.approx(0.5 * weighs[1])
    assert [event for event in balanced if event.clip] == [event for event in events if event.clip]


def test_evidence_in_pieces_is_nearly_that_of_the_whole(clip):
    model = lgmd.LGMD2(lgmd.preset("lgmd2", k=0.5, T_ffi=1e9))
    (whole,) = evaluate(model, [clip]).evidence
    parts = list(pieces(clip))
    assert np.ptp(whole) > 0.1
    for part, trace in zip(parts, evaluate(model, parts).evidence, strict=True):
        judged = part.in_silence() | part.in_windows().any(axis=0)
        np.testing.assert_allclose(trace[judged], whole[part.index[judged]], atol=5e-3)
