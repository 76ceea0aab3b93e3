"""Detectors at equal budgets of false alarms, against counts by hand, brute force and scipy's own intervals."""

import dataclasses

import numpy as np
import pytest
import scipy

from lgmd2jax.alarms import Comparison, Counts, Detector, Evaluation, LabelledClip
from lgmd2jax.alarms._comparison import more_hits, threshold_within


def silence(trace, source: str | None = "s", fps=10):
    name, frames = source or "rendered", np.zeros((len(trace), 3, 3))
    return LabelledClip.of(name, frames, fps, silent=[(0, len(trace) - 1)], source=source)


def hit(source="s"):
    return LabelledClip.of(source, np.zeros((4, 3, 3)), 10, windows=[(0, 3)], source=source)


def minute(**levels):
    """The evidence of a minute at 10 frames a second: 0 but at some frames."""
    trace = np.zeros(600)
    for frame, level in levels.items():
        trace[int(frame[1:])] = level
    return trace


def test_the_lowest_threshold_within_a_budget():
    trace = minute(f10=0.9, f50=0.7, f51=0.7, f52=0.6, f300=0.5)
    evaluation = Evaluation((silence(trace),), (trace,), np.inf)
    assert threshold_within(evaluation, 0) > 0.9
    assert threshold_within(evaluation, 1) == pytest.approx(0.8)
    assert threshold_within(evaluation, 2) == pytest.approx(0.55)
    assert threshold_within(evaluation, 3) == 0  # at 0 the alarm is always on, and was raised once


def test_an_alarm_that_stays_on_does_not_buy_a_low_threshold():
    trace = np.tile([0.2, 0.6], 300)  # 300 alarms at .6, one at .2
    evaluation = Evaluation((silence(trace),), (trace,), np.inf)
    assert threshold_within(evaluation, 4) > 0.6


def test_false_alarms_at_all_thresholds_are_those_counted_one_by_one():
    chance = np.random.default_rng(0)
    clips = tuple(
        LabelledClip.of("c", np.zeros((50, 3, 3)), 10, windows=[(20, 25)], silent=[(0, 9), (12, 19), (30, 44)])
        for _ in range(5)
    )
    evaluation = Evaluation(clips, tuple(chance.random(50).round(1) for _ in clips), 0.5)
    thresholds = np.linspace(0, 1.1, 23)
    expected = []
    for threshold in thresholds:
        counted = hits = 0
        for clip, trace in zip(clips, evaluation.evidence, strict=True):
            before = False
            hits += max(trace[20:26]) >= threshold
            for frame, level in enumerate(trace):
                now = level >= threshold and any(first <= frame <= last for first, last in clip.silent)
                counted += now and not before
                before = now
        expected.append((hits / 5, counted))
    hits, false = evaluation.operating_curve(thresholds)
    np.testing.assert_allclose(hits, [pair[0] for pair in expected])
    np.testing.assert_array_equal(evaluation.raised(thresholds), [pair[1] for pair in expected])
    np.testing.assert_allclose(false, evaluation.raised(thresholds) / evaluation.silent_minutes)


def detector(noise_a, noise_b, peak_a, peak_b, T_sp=np.inf):
    """On two sources, each with a silent minute and a window."""
    clips = (silence(noise_a, "a"), hit("a"), silence(noise_b, "b"), hit("b"))
    traces = (noise_a, np.full(4, peak_a), noise_b, np.full(4, peak_b))
    return Detector(Evaluation(clips, traces, T_sp))


def test_a_source_is_judged_by_thresholds_that_the_others_chose():
    quiet, loud = minute(f9=0.3, f99=0.2), minute(f9=0.9, f30=0.8, f60=0.7, f90=0.1)
    comparison = Comparison.of({"model": detector(quiet, loud, 0.5, 0.5, 0.4)})
    compared = comparison.detectors["model"]
    # Of 1 a minute: .25 by the quiet one, on the loud one; .85 by the loud one, on the quiet one.
    outcome = compared.at_budgets[1.0]
    assert outcome.threshold == pytest.approx((0.25, 0.85))
    assert outcome.counts.hits.tolist() == [0, 0, 0, 1]
    assert outcome.counts.false_alarms.tolist() == [0, 0, 3, 0]
    assert compared.own is not None
    assert compared.own.counts.hits.tolist() == [0, 1, 0, 1]
    assert compared.own.counts.false_alarms.tolist() == [0, 0, 3, 0]


def test_a_fitted_detector_is_judged_by_the_fit_without_the_source():
    quiet, never = minute(f9=0.3), minute()
    whole, other = detector(quiet, quiet, 0.9, 0.9, 0.4), detector(never, never, 0.1, 0.1, 0.2)
    blind = Detector(whole.evaluation, {"a": other.evaluation})
    own = Comparison.of({"model": blind}).detectors["model"].own
    assert own is not None
    assert own.counts.hits.tolist() == [0, 0, 0, 1]
    assert own.threshold == (0.2, 0.4)


def test_thresholds_of_other_clips():
    loud = minute(f9=0.9, f30=0.8, f60=0.7)
    model = Detector(anonymous(detector(loud, loud, 0.5, 0.75).evaluation))
    training = Detector(Evaluation((silence(loud),), (loud,), np.inf))
    comparison = Comparison.of({"model": model}, ("other clips", {"model": training}))
    assert comparison.training == "other clips"
    outcome = comparison.detectors["model"].at_budgets[2.0]
    assert outcome.threshold == pytest.approx((0.75, 0.75))
    assert outcome.counts.hits.sum() == 1
    assert outcome.counts.false_alarms.sum() == 4


def anonymous(evaluation):
    """The same clips, of no source."""
    clips = tuple(dataclasses.replace(clip, source=None) for clip in evaluation.clips)
    return dataclasses.replace(evaluation, clips=clips)


def test_thresholds_of_other_clips_and_of_the_other_sources():
    """For the source b by the fit without it, which raises other alarms on all clips; a is judged by the whole one."""
    quiet, loud, rendered = minute(f9=0.3), minute(f9=0.9, f30=0.8, f60=0.7), (silence(np.zeros(600), None),)
    whole = detector(quiet, loud, 0.5, 0.5, 0.4).evaluation
    blind = dataclasses.replace(whole, evidence=tuple(np.zeros(len(trace)) for trace in whole.evidence))
    trained = [Evaluation(rendered, (minute(f9=0.6, f30=level, f60=0.4),), 0.4) for level in (0.55, 0.5)]
    films = "films", {"model": Detector(trained[0], {"b": trained[1]})}
    comparison = Comparison.of({"model": Detector(whole, {"b": blind})}, films)
    assert comparison.training == "films and the other sources"
    # Two alarms in two minutes: for a .9 and .8, but not .7; for b .6 and .5, but not .4.
    outcome = comparison.detectors["model"].at_budgets[1.0]
    assert outcome.threshold == pytest.approx((0.45, 0.75))
    assert outcome.counts.false_alarms.sum() == 0


def test_one_source_chooses_for_itself_and_says_so():
    trace = minute(f9=0.9, f30=0.8)
    comparison = Comparison.of({"model": Detector(Evaluation((silence(trace),), (trace,), 0.5))})
    assert comparison.training.startswith("the same clips, since no silence")
    with pytest.raises(ValueError, match="no clip has a silence"):
        Comparison.of({"model": Detector(Evaluation((hit(),), (np.ones(4),), 0.5))})


def counts(hits, windows):
    none = np.zeros(len(hits), int)
    return Counts(np.array(hits), np.array(windows), none, np.ones(len(hits)))


def test_a_paired_interval_covers_as_often_as_it_says():
    """Thirty sources of two windows; the second detector hits where the first does, and besides in a tenth of cases."""
    chance, covered = np.random.default_rng(1), 0
    for _ in range(60):
        ours = chance.random((30, 2)) < 0.6
        others = ours & (chance.random((30, 2)) < 0.8)
        share = more_hits(counts(ours.sum(1), [2] * 30), counts(others.sum(1), [2] * 30), np.arange(30))
        assert share.value == pytest.approx((ours.sum() - others.sum()) / 60)
        covered += share.low <= 0.12 <= share.high
    assert covered >= scipy.stats.binom.ppf(0.001, 60, 0.9)


def test_pairs_that_agree_leave_nothing_open_and_one_source_everything():
    same = counts([1, 0, 2], [2, 1, 2])
    assert more_hits(same, same, np.arange(3)) == (0, 0, 0)
    alone = more_hits(counts([2, 1], [2, 2]), counts([1, 1], [2, 2]), np.zeros(2, int))
    assert alone.value == 0.25
    assert np.isnan(alone.low)


def test_content_is_whole_and_in_numbers_of_one_s_own():
    quiet, loud = minute(f9=0.3, f99=0.2), minute(f9=0.9, f30=0.8, f60=0.7, f90=0.1)
    two = {"model": detector(quiet, loud, 0.5, 0.5, 0.4), "difference": detector(loud, quiet, 0.95, 0.1)}
    content = Comparison.of(two).content()
    model, other = content["detectors"]["model"], content["detectors"]["difference"]
    wilson = scipy.stats.binomtest(2, 2).proportion_ci(method="wilson")
    assert model["hits"] == {"count": 2, "windows": 2, "value": 1, "low": wilson.low, "high": wilson.high}
    rate = model["false_alarms_per_minute"]
    assert (rate["count"], rate["minutes"], rate["value"]) == (3, pytest.approx(2), pytest.approx(1.5))
    garwood = scipy.stats.poisson(rate["low"] * 2).sf(2), scipy.stats.poisson(rate["high"] * 2).cdf(3)
    assert garwood == pytest.approx((0.025, 0.025))
    assert set(model["budgets"]) == set(other["budgets"]) == {"1", "2", "4"}
    assert other["threshold"] == other["budgets"]["1"]["threshold"]  # which has none of its own
    assert "model_hits_more" not in model["budgets"]["1"]
    assert other["budgets"]["1"]["model_hits_more"]["value"] == pytest.approx(0.0)
    assert [clip["source"] for clip in content["clips"]] == ["a", "a", "b", "b"]
    assert sum(clip["false_alarms"] for clip in content["clips"]) == 3
