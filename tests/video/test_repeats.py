"""Repeated frames: found where a conversion made them, marked in a clip, and as recorded clips show them."""

import json

import numpy as np
import pytest

from lgmd2jax._video.clip import open_clip
from lgmd2jax._video.repeats import find_repeats
from tests.videos import conversion, noise, write_video


def repeats_of(path):
    repeats = open_clip(path).without_repeats().repeats
    assert repeats is not None
    return set(np.flatnonzero(repeats).tolist())


@pytest.mark.parametrize("source", [25, 24, 20, 15, 10])
def test_repeats_of_a_frame_rate_conversion_are_found_all_and_only(source):
    generator = np.random.default_rng(source)
    shown = conversion(source, 30, 150)
    repeated = np.diff(shown, prepend=-1) == 0
    # A lively clip with a quiet stretch, and the coding noise of a repeat.
    motion = np.where((np.arange(150) > 60) & (np.arange(150) < 100), 1.0, 5.0) * generator.uniform(0.8, 1.3, 150)
    changes = np.where(repeated, 0.12 * motion * generator.uniform(0.1, 1.5, 150), motion)
    changes[0] = 0
    found = find_repeats(changes)
    assert not (found & ~repeated).any()
    # Within reach of a sudden change of the motion, the lesser side decides, and a repeat may be kept.
    steady = np.all([abs(np.arange(150) - border) > 8 for border in (60, 100)], axis=0)
    np.testing.assert_array_equal(found[steady], repeated[steady])


def test_a_scene_that_stands_still_repeats_nothing():
    assert not find_repeats(np.zeros(50)).any()
    assert not find_repeats(np.random.default_rng(0).uniform(0.3, 0.6, 200)).any()
    assert not find_repeats(np.repeat([0.0, 5.0, 0.2], 40)).any()
    for count in (0, 1, 2):
        assert not find_repeats(np.zeros(count)).any()


def test_dropping_repeats_marks_them_and_slows_the_clock_to_the_effective_rate(tmp_path):
    shown = conversion(20, 30, 30)
    clip = open_clip(write_video(tmp_path / "clip.mkv", noise(20)[shown])).without_repeats()
    frames = list(clip)
    repeated = np.diff(shown, prepend=-1) == 0
    np.testing.assert_array_equal([frame.repeated for frame in frames], repeated)
    assert repeated.sum() == 10
    assert clip.count == 30
    assert clip.effective_fps == pytest.approx(20)
    assert [frame.interval for frame in frames if not frame.repeated] == pytest.approx([50.0] * 20)
    assert [frame.time for frame in frames] == [i * 1000 / 30 for i in range(30)]


def test_without_a_steady_clock_a_dropped_repeat_adds_to_the_interval(tmp_path):
    shown = np.array([0, 1, 2, 2, 3, 4, 5, 6, 7])
    stamps = np.array([0, 33, 67, 100, 133, 267, 300, 333, 367])
    clip = open_clip(write_video(tmp_path / "clip.mkv", noise(8)[shown], stamps_ms=stamps)).without_repeats()
    assert clip.regular is False
    frames = [frame for frame in clip if not frame.repeated]
    assert [frame.index for frame in frames] == [0, 1, 2, 4, 5, 6, 7, 8]
    np.testing.assert_allclose([frame.interval for frame in frames][1:], np.diff(np.delete(stamps, 3)), atol=1.5)


@pytest.mark.parametrize(
    ("file", "until", "recall", "precision"),
    # After frame 218 of c29 nothing moves: what repeats there cannot be told from what stands still.
    # The eye missed about every second one, as those of nc03 below show, which lie on a grid.
    [("c29.mp4", 219, 0.97, 0.5), ("tc16.mp4", 120, 1, 0.6), ("nc03.mp4", 151, 1, 0.45), ("nc07.mp4", 282, 0.5, 0.6)],
)
def test_repeats_that_were_seen_by_eye_are_found_and_few_others(data, file, until, recall, precision):
    clips = json.loads((data / "clips" / "annotations.json").read_text())["clips"]
    (judged,) = (set(clip["duplicate_frames"]) for clip in clips if clip["file"] == file)
    judged = {frame for frame in judged if frame < until}
    marked = {frame for frame in repeats_of(data / "clips" / file) if frame < until}
    assert len(marked & judged) >= recall * len(judged)
    assert len(marked & judged) >= precision * len(marked)


def test_the_repeats_of_a_recorded_conversion_lie_on_its_grid(data):
    # nc03 was converted from 25 fps: it repeats every sixth frame, which the eye saw for half of them only.
    assert repeats_of(data / "clips" / "nc03.mp4") == {1, 2, *range(4, 151, 6)}


def test_a_clip_without_repeats_keeps_its_frames(data):
    assert not repeats_of(data / "clips" / "tc22.mp4")
