"""What a model does on labelled clips, against the network's own alarms and counts by hand."""

import dataclasses

import jax
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.alarms import Evaluation, LabelledClip, Rendering, evaluate
from lgmd2jax.alarms._report import clip_section

EYE = lgmd.Eye.from_field_of_view(24, 32, 70.0, 30.0, "pinhole")
MODEL = lgmd.LGMD2(lgmd.preset("lgmd2", T_sp=0.65, k=0.5), eye=EYE)


@pytest.fixture(scope="module")
def clips():
    return tuple(Rendering(6, seed=3).clips(EYE))


def test_alarms_are_those_of_the_network_at_any_threshold(clips):
    evaluation = evaluate(MODEL, clips)
    on = 0
    for T_sp in (0.6, 0.65, 0.75):
        model = dataclasses.replace(MODEL, parameters=lgmd.preset("lgmd2", T_sp=T_sp, k=0.5))
        for clip, trace in zip(clips, evaluation.evidence, strict=True):
            collision = np.asarray(model(clip.frames.astype(np.float32)).collision)
            np.testing.assert_array_equal(trace >= T_sp, collision > 0)
            on += collision.sum()
    assert on > 0


@pytest.mark.parametrize("N_sp", [0.4, 1.0, 4.3, 5.0])
def test_a_number_of_spikes_that_is_not_whole_counts_as_in_the_network(clips, N_sp):
    model = dataclasses.replace(MODEL, parameters=lgmd.preset("lgmd2", T_sp=0.65, k=0.5, N_sp=N_sp))
    on = 0
    for clip, trace in zip(clips, evaluate(model, clips).evidence, strict=True):
        collision = np.asarray(model(clip.frames.astype(np.float32)).collision)
        np.testing.assert_array_equal(trace >= 0.65, collision > 0)
        on += collision.sum()
    assert on > 0


def test_the_numbers_of_a_clip():
    trace = np.array([0.5, 0.7, 0.5, 0.5, 0.9, 0.9, 0.5, 0.72, 0.5, 0.6])
    clip = LabelledClip.of("c", np.zeros((10, 3, 3)), 10, windows=[(3, 5)], silent=[(0, 1), (7, 9)], contact=7)
    (verdict,) = Evaluation((clip,), (trace,), 0.65).verdicts()
    assert verdict.alarms == ((1, 1), (4, 5), (7, 7))
    assert verdict.hits == (True,)
    assert verdict.false_alarms == 2
    assert verdict.warning_ms == pytest.approx(300)
    assert verdict.margin == pytest.approx(0.65 - 0.72)
    assert not verdict.right
    (quiet,) = Evaluation((clip,), (trace,), 0.8).verdicts()
    assert quiet.right
    assert quiet.margin == pytest.approx(min(0.9 - 0.8, 0.8 - 0.72))


@pytest.mark.parametrize(
    ("contacts", "sentence"),
    [
        ([7], "The first alarm in a window comes 300 ms before contact."),
        ([7, 7], "The first alarm in a window comes 300 ms before contact."),
        ([7, 9, 8], "The first alarm in a window comes 300 to 500 ms before contact, median 400."),
    ],
)
def test_the_time_before_contact_is_a_span_where_windows_differ(contacts, sentence):
    trace = np.where(np.arange(10) == 4, 0.9, 0.5)
    clips = tuple(LabelledClip.of("c", np.zeros((10, 3, 3)), 10, windows=[(3, 5)], contact=at) for at in contacts)
    section = clip_section(Evaluation(clips, (trace,) * len(clips), 0.65), {})
    assert sentence in section.sentences
    windows = "1 window" if len(clips) == 1 else f"{len(clips)} windows"
    assert f" of {windows}, with " in section.sentences[0]


def test_hits_and_false_alarms_over_all_thresholds():
    silence = LabelledClip.of("s", np.zeros((600, 3, 3)), 10, silent=[(0, 599)])
    hit = LabelledClip.of("h", np.zeros((4, 3, 3)), 10, windows=[(0, 3)])
    noisy = np.full(600, 0.5)
    noisy[[10, 50, 51, 300]] = 0.7, 0.8, 0.8, 0.6
    evaluation = Evaluation((silence, hit, hit), (noisy, np.full(4, 0.75), np.full(4, 0.65)), 0.69)
    hits, false = evaluation.operating_curve(np.array([0.55, 0.69, 0.72, 0.9]))
    assert hits.tolist() == [1, 0.5, 0.5, 0]
    assert false.tolist() == [3, 2, 1, 0]  # in a minute


def test_intervals_of_a_score():
    """Wilson's interval of 9 in 10, and Garwood's of no and of two events, from tables."""
    hit = LabelledClip.of("h", np.zeros((4, 3, 3)), 10, windows=[(0, 3)])
    silence = LabelledClip.of("s", np.zeros((600, 3, 3)), 10, silent=[(0, 599)])
    traces = (*[np.full(4, 0.9)] * 9, np.full(4, 0.5), np.full(600, 0.5))
    score = Evaluation((*[hit] * 10, silence), traces, 0.7).score()
    assert score.hits == pytest.approx((0.9, 0.5958, 0.9821), abs=1e-4)
    assert score.false_alarms == pytest.approx((0, 0, 3.6889), abs=1e-4)
    assert str(score) == "hits 90 (59.6 to 98.2) % of the windows, 0 (0 to 3.69) false alarms a minute"
    noisy = np.full(600, 0.5)
    noisy[[3, 90]] = 0.8
    assert Evaluation((silence,), (noisy,), 0.7).score().false_alarms == pytest.approx((2, 0.2422, 7.2247), abs=1e-4)


def test_no_clips():
    with pytest.raises(ValueError, match="clips is empty"):
        evaluate(MODEL, ())


def test_rendered_labels_follow_the_time_to_contact():
    how = Rendering(8, seed=1, alarm_below_ms=700, silent_above_ms=1500)
    clips = list(how.clips(EYE))
    encounters = list(lgmd.stimuli.encounters(EYE, jax.random.key(1), 8))
    for clip, encounter in zip(clips, encounters, strict=True):
        left, judged = np.asarray(encounter.time_to_contact_ms), np.arange(len(clip.frames)) >= 10
        np.testing.assert_array_equal(clip.in_windows().any(axis=0), judged & (left <= 700))
        np.testing.assert_array_equal(clip.in_silence(), judged & (left > 1500))
        if encounter.kind == "collision":
            assert clip.contact_ms == pytest.approx(clip.time[-1] + left[-1], abs=1000 / 30)
        else:
            assert clip.contact is None
    assert sum(bool(clip.windows) for clip in clips) == 4
