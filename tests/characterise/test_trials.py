"""The stimuli of the exam: what is shown is what the windows say."""

import dataclasses

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax._characterise import trials
from lgmd2jax._characterise.exam import Exam
from tests.characterise.signals import EXAM

SMALL = lgmd.Eye(rows=12, cols=16, degrees_per_pixel=8.0, fps=50.0)
TRIALS = {trial.name: trial for trial in trials.all_trials(SMALL, 0.0)}


def test_names_are_unique_and_cover_what_rows_ask_for():
    names = [trial.name for group in EXAM.groups for trial in group]
    assert len(names) == len(set(names)) == 73
    assert trials.contrast(-0.9) == trials.deviating(0.0) == trials.loom(40.0) == trials.REFERENCE


@pytest.mark.parametrize(
    "name",
    [
        trials.loom(10.0),
        trials.RECESSION,
        trials.SQUARE,
        trials.translation(),
        trials.bar("light", grows=False),
        trials.change("quarter", 80.0),
        trials.grating(0.05, 4.0),
    ],
)
def test_nothing_moves_outside_of_the_window(name):
    trial = TRIALS[name]
    frames, time = trial.frames(SMALL), trial.time
    assert frames.dtype == np.float32
    assert len(frames) == trial.count
    changed = time[1:][np.abs(np.diff(frames, axis=0)).max(axis=(1, 2)) > 1e-4]
    frame = 1000 / trial.fps
    assert trial.begin - 1e-6 <= changed[0]
    assert changed[-1] < trial.end + frame
    assert time[0] <= trial.begin - trials.LEAD + frame
    assert time[-1] >= trial.end + trials.LEAD - frame


def test_groups_have_one_length_and_rate():
    for group in EXAM.groups:
        assert len({(trial.fps, trial.count) for trial in group}) == 1
        assert all(len(trial.time) == trial.count for trial in group)
    assert len(EXAM.groups) <= 6


def test_gratings_that_alias_are_left_out():
    assert trials.grating(0.05, 4.0) in TRIALS
    assert trials.grating(0.1, 4.0) not in TRIALS  # .8 cycles a pixel
    slow = {trial.name for trial in trials.all_trials(dataclasses.replace(SMALL, fps=15.0), 0.0)}
    assert trials.grating(0.05, 4.0) in slow
    assert trials.grating(0.05, 10.0) not in slow


def test_the_finer_rate_is_always_another():
    assert [trials.finer_rate(fps) for fps in (60.0, 100.0, 150.0, 200.0, 240.0)] == [200, 200, 200, 400, 480]


def test_the_square_has_the_area_of_the_disc():
    darkness = []
    for name in (trials.REFERENCE, trials.SQUARE):
        trial = TRIALS[name]
        frames = trial.frames(SMALL)
        at = np.argmin(np.abs(trial.time + 150))  # 30 degrees
        darkness.append((200 - frames[at]).sum())
    assert darkness[1] / darkness[0] == pytest.approx(1, abs=0.03)


def test_a_shift_moves_objects_by_that_part_of_a_pixel():
    aside = {trial.name: trial for trial in trials.all_trials(SMALL, 0.5)}[trials.translation()]
    straight = TRIALS[trials.translation()]
    first, second = (200 - trial.frames(SMALL)[40] for trial in (straight, aside))
    for axis, count in ((0, SMALL.cols), (1, SMALL.rows)):
        places = np.arange(count)
        centres = [(each.sum(axis=axis) * places).sum() / each.sum() for each in (first, second)]
        assert abs(centres[1] - centres[0]) == pytest.approx(0.5, abs=0.02)


def test_textured_scenes_keep_their_mean_and_are_noisy():
    trial = TRIALS[trials.textured(trials.REFERENCE)]
    frames = trial.frames(SMALL)
    assert frames[:20].mean() == pytest.approx(200, abs=2)
    still = frames[:20] - frames[:20].mean(axis=0)
    assert still.std() * np.sqrt(20 / 19) == pytest.approx(trials.NOISE, rel=0.05)
    assert frames[:20].mean(axis=0).std() > 1.5  # of the photograph, as 8 degrees a pixel blur it
    np.testing.assert_array_equal(frames, trial.frames(SMALL))


def test_frames_are_rendered_once():
    exam = Exam(SMALL, only=(trials.change("field", 20.0),))
    (trial,) = exam.groups[0]
    assert exam.frames(trial) is exam.frames(trial)
    assert exam == Exam(SMALL, only=(trials.change("field", 20.0),))
    assert exam != Exam(SMALL, shift=0.5, only=(trials.change("field", 20.0),))


def test_the_photograph_drifts_at_20_degrees_per_second():
    """By 8 degrees, two pixels, in 20 frames of 20 ms."""
    eye = dataclasses.replace(SMALL, rows=24, cols=32, degrees_per_pixel=4.0)
    still, drifting = (
        {trial.name: trial for trial in trials.all_trials(eye, 0.0)}[name].frames(eye)
        for name in (trials.STILL, trials.DRIFTING)
    )
    np.testing.assert_array_equal(still[0], still[20])
    before, after = drifting[0][:8], drifting[20][:8]  # above the object, which stands
    np.testing.assert_allclose(before[:, :-2], after[:, 2:], atol=1e-3)
    assert np.abs(before - after).max() > 5


def test_another_seed_changes_noise_and_texture_alone():
    eye = lgmd.Eye(rows=10, cols=12, degrees_per_pixel=8.0, fps=20.0)
    first, other = ({trial.name: trial for trial in trials.all_trials(eye, 0.0, seed)} for seed in (0, 3))
    assert list(first) == list(other)
    changed = {name for name in first if not np.array_equal(first[name].frames(eye), other[name].frames(eye))}
    assert changed == {name for name, trial in first.items() if trial.textured} | {trials.STILL, trials.DRIFTING}
