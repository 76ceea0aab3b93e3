"""Why a window was missed and what drove a false alarm, on clips in which that is known."""

import dataclasses

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.alarms import Drive, Evaluation, LabelledClip, evaluate
from lgmd2jax.alarms._report import clip_section, why, write_table
from tests.clips import loom

T_SP = 0.6
PART = {name: np.full(20, 0.5) for name in ("field", "row", "col")}


def judged(trace, uninhibited, inhibited, **labels):
    clip = LabelledClip.of("c", np.zeros((20, 3, 3)), 10, **labels)
    drive = Drive(np.array(uninhibited, float), np.array(inhibited, bool), **PART)
    (verdict,) = Evaluation((clip,), (np.array(trace, float),), T_SP, (drive,)).verdicts()
    return verdict


def curve(high=(), level=0.7):
    trace = np.full(20, 0.5)
    trace[list(high)] = level
    return trace


@pytest.mark.parametrize(
    ("trace", "uninhibited", "inhibited", "expected", "words"),
    [
        (curve(), curve([7]), np.arange(20) < 7, ("inhibited", 0.4, 0.5), "5-9: inhibited in 40% of it"),
        (curve([12]), curve([12]), np.zeros(20), ("late", 0, 0.5), "5-9: late by 300 ms"),
        (curve([6], 0.59), curve([6], 0.59), np.zeros(20), ("weak", 0, 0.59), "5-9: too weak, 0.590 < 0.600"),
        (curve([15]), curve([7, 15]), np.ones(20), ("inhibited", 1, 0.5), "inhibited in 100% of it, late by 600 ms"),
    ],
)
def test_why_a_window_was_missed(trace, uninhibited, inhibited, expected, words):
    verdict = judged(trace, uninhibited, inhibited, windows=[(5, 9)])
    (miss,) = verdict.misses
    assert miss.window == (5, 9)
    assert (miss.why, miss.inhibited, miss.evidence) == (expected[0], pytest.approx(expected[1]), expected[2])
    assert words in why(verdict, T_SP)


def test_an_alarm_long_after_a_window_is_not_late():
    verdict = judged(curve([19]), curve([19]), np.zeros(20), windows=[(2, 5)])  # 1.4 s
    assert verdict.misses[0].why == "weak"
    assert np.isnan(verdict.misses[0].late_ms)


def test_what_is_right_needs_no_reason():
    verdict = judged(curve([6]), curve([6]), np.zeros(20), windows=[(5, 9)], silent=[(10, 19)])
    assert verdict.misses == verdict.raised == ()
    assert why(verdict, T_SP) == ""


MODEL = lgmd.LGMD2(lgmd.preset("lgmd2", k=0.3, T_s=5.0, T_sp=0.55, N_sp=1.0))


def corner(rows, cols):
    """A clip in which a part of the picture darkens from frame 8 on, for as long as the alarm needs."""
    frames = np.full((20, 12, 15), 200.0)
    for t in range(8, 14):
        frames[t:, rows, cols] -= 25
    return frames


def test_a_false_alarm_comes_from_the_part_of_the_field_that_changed():
    clip = LabelledClip.of("c", corner(slice(8, 12), slice(0, 5)), 30, silent=[(0, 19)])
    (verdict,) = evaluate(MODEL, [clip]).verdicts()
    alarm = verdict.raised[0]
    assert 8 <= alarm.frames[0] <= 11
    assert alarm.row == pytest.approx(10 / 12, abs=0.05)
    assert alarm.col == pytest.approx(2.5 / 15, abs=0.05)
    assert 0 < alarm.field <= 1.6 * 20 / 180  # the change spreads to the neighbours
    assert "of the field, lower left" in why(verdict, 0.55)
    whole = LabelledClip.of("c", corner(slice(None), slice(None)), 30, silent=[(0, 19)])
    far = dataclasses.replace(MODEL, parameters=dataclasses.replace(MODEL.parameters, T_ffi=1e9))
    assert "of the field, all over" in why(evaluate(far, [whole]).verdicts()[0], 0.55)


@pytest.mark.parametrize("mechanisms", [(), ("size", "shunt", "lag", "membrane")])
def test_uninhibited_is_what_the_network_does_without_inhibition(mechanisms):
    clip = LabelledClip.of("c", loom(0), 30, windows=[(4, 20)])
    model = dataclasses.replace(MODEL, mechanisms=mechanisms)
    evaluation, ablated = evaluate(model, [clip]), evaluate(lgmd.ablate(model, "ffi"), [clip])
    np.testing.assert_allclose(evaluation.drives[0].uninhibited, ablated.evidence[0], atol=1e-6)
    response = model(loom(0).astype(np.float32), 30)
    level = model.cell.inhibited_from
    np.testing.assert_array_equal(evaluation.drives[0].inhibited, np.asarray(response.ffi) > level)


def test_report_and_table_tell_the_frame_rate_and_why(tmp_path):
    clip = LabelledClip.of("c", corner(slice(8, 12), slice(0, 5)), 12.5, silent=[(0, 19)])
    evaluation = evaluate(MODEL, [clip])
    section = clip_section(evaluation, {})
    assert section.rows[0][section.columns.index("fps|")] == "12.5"
    assert "lower left" in section.rows[0][section.columns.index("why")]
    write_table(tmp_path / "clips.csv", evaluation)
    head, row = (tmp_path / "clips.csv").read_text().splitlines()
    assert dict(zip(head.split(","), row.split(","), strict=False))["fps"] == "12.5"
    assert "lower left" in row
