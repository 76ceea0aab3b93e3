"""The grade of a target, and the score of silence beside it."""

import numpy as np
import pytest

from lgmd2jax.fitting._curve import GRADES
from tests.fitting.fits import curve

BUMP = curve().target


def moved(share: float) -> np.ndarray:
    """The target's departure from rest, all of it weaker by a share: silence is 1."""
    return 0.5 + (1 - share) * (BUMP - 0.5)


def test_silence_misses_by_the_whole_response():
    shown = curve()
    np.testing.assert_allclose(shown.rmse("silence"), np.sqrt(np.mean((BUMP - 0.5) ** 2)))
    recorded = curve(channel="rate", rest=4.2, target=np.full(30, 4.2), hard=np.full(30, 5.2))
    assert recorded.rmse("silence") == 0


@pytest.mark.parametrize(
    ("share", "grade"), [(0, "good"), (0.2, "good"), (0.45, "fair"), (0.6, "missed"), (1, "missed")]
)
def test_a_response_is_graded_by_the_variance_that_is_explained(share, grade):
    assert curve(hard=moved(share)).grade == grade


def test_half_of_the_variance_is_not_enough_where_silence_would_do_nearly_as_well():
    wave = 0.5 + 0.3 * np.sin(np.arange(30) * 2 * np.pi / 30)
    shown = curve(target=wave, hard=0.5 + (1 - np.sqrt(0.49)) * (wave - 0.5))
    assert shown.r2() == pytest.approx(0.51)
    assert shown.grade == "missed"


def test_a_weak_response_that_silence_meets_within_a_tenth_of_the_span_is_missed_by_silence():
    weak = curve(target=0.5 + 0.1 * (BUMP - 0.5), hard=np.full(30, 0.5))
    assert weak.rmse() < 0.1 * weak.span
    assert weak.grade == "missed"


@pytest.mark.parametrize(
    ("miss", "grade"), [(0, "good"), (0.029, "good"), (0.031, "fair"), (0.099, "fair"), (0.101, "missed")]
)
def test_where_quiet_is_asked_the_span_is_the_measure(miss, grade):
    assert curve(target=np.full(30, 0.5), hard=np.full(30, 0.5 + 0.25 * miss)).grade == grade


@pytest.mark.parametrize(("level", "grade"), [(0.9, "good"), (0.8, "good"), (0.72, "fair"), (0.65, "missed")])
def test_a_level_away_from_rest_has_no_r2_and_is_graded_about_rest(level, grade):
    assert curve(target=np.full(30, 0.9), hard=np.full(30, level)).grade == grade


@pytest.mark.parametrize(("share", "grade"), [(1.0, "good"), (0.9, "good"), (0.8, "fair"), (0.6, "missed")])
def test_a_band_is_graded_by_the_share_of_samples_within(share, grade):
    """Silence lies below the band throughout."""
    hard = np.where(np.arange(30) < 30 * share, 0.8, 0.5)
    shown = curve(target=np.full(30, 0.7), upper=np.full(30, 0.9), hard=hard)
    assert shown.inside("silence") == 0
    assert shown.grade == grade


def test_a_band_that_silence_meets_as_well_is_missed_unless_it_asks_for_quiet():
    response = {"target": np.where(np.arange(30) < 6, 0.7, 0.5), "upper": np.full(30, 0.9)}
    assert curve(**response, hard=np.full(30, 0.5)).grade == "missed"  # 80 % within
    assert curve(target=np.full(30, 0.5), upper=np.full(30, 0.6), hard=np.full(30, 0.5)).grade == "good"


def test_the_rule_is_told_with_its_numbers():
    rule = " ".join(GRADES)
    for number in (
        "at least 0.9",
        "at least 0.5",
        "at most 0.5 of that of silence",
        "less than 1%",
        "most 3%",
        "most 10%",
    ):
        assert number in rule


def test_whether_a_target_is_met_is_the_old_name_of_its_grade():
    with pytest.warns(DeprecationWarning, match=r"Curve.met is now Curve.grade"):
        assert curve().met
    with pytest.warns(DeprecationWarning, match=r"Curve.met is now Curve.grade"):
        assert not curve(hard=moved(1)).met
