"""Clips by chance: time to contact by what is seen, as many collisions as asked, the same for the same key."""

import collections

import jax
import numpy as np
import pytest

from lgmd2jax import Eye, stimuli
from lgmd2jax._video.repeats import find_repeats
from lgmd2jax.stimuli import _encounter, _shapes
from tests.videos import conversion

EYE = Eye.from_field_of_view(36, 64, 70.0, 30.0, "pinhole")
KEY = jax.random.key(3)


@pytest.fixture(scope="module")
def clips_and_traces():
    """Clips of every kind, and how often a disc's drawing was traced for them."""
    traces = []
    with pytest.MonkeyPatch.context() as patch:
        disc = _shapes.Disc
        patch.setattr(_shapes, "Disc", lambda *args: traces.append(args) or disc(*args))
        return list(stimuli.encounters(EYE, KEY, 36)), len(traces)


@pytest.fixture(scope="module")
def clips(clips_and_traces):
    return clips_and_traces[0]


@pytest.fixture(scope="module")
def of(clips):
    groups = collections.defaultdict(list)
    for clip in clips:
        groups[clip.kind].append(clip)
    return groups


def test_half_are_collisions_and_the_other_kinds_come_equally_often(of):
    assert {kind: len(clips) for kind, clips in of.items()} == {
        kind: 18 if kind == "collision" else 3 for kind in stimuli.ENCOUNTERS
    }


def test_clips_are_in_8_bits_from_0_ms_on(clips):
    for clip in clips:
        frames = np.asarray(clip.stimulus.frames)
        assert frames.shape == (90, 36, 64)
        assert np.array_equal(frames, np.rint(frames))
        assert frames.min() >= 0
        assert frames.max() <= 255
        assert np.allclose(clip.stimulus.time, np.arange(90) / 30 * 1000)


def test_hundreds_of_clips_compile_little(clips_and_traces):
    """Before a plain or a textured ground, on its way in depth or across, in each of four lengths of film."""
    assert clips_and_traces[1] <= 16


def repeats(clip):
    """Which frames repeat the one before; noise tells all others apart, whatever stands still."""
    frames = np.asarray(clip.stimulus.frames)
    return np.r_[False, (frames[1:] == frames[:-1]).all((1, 2))]


def shot_fps(clip):
    return clip.stimulus.fps * float(np.mean(~repeats(clip)))


def test_half_of_the_clips_are_films_of_fewer_frames(clips):
    rates = collections.Counter(round(shot_fps(clip), 6) for clip in clips)
    assert rates.keys() == {20, 24, 25, 30}
    assert rates[30] == pytest.approx(18, abs=9)  # three standard deviations


def test_repeats_lie_where_a_conversion_puts_them(clips):
    """Each frame of the file shows the film's latest one: a clock of 20 Hz, read by one of 30."""
    for clip in clips:
        ticks = conversion(round(shot_fps(clip)), 30, 90)
        assert np.array_equal(repeats(clip), np.diff(ticks, prepend=-1) == 0)
        if clip.kind == "collision":
            left = clip.time_to_contact_ms
            assert np.allclose(left[0] - left, ticks * 1000 / shot_fps(clip))


def test_what_drops_repeats_of_recorded_clips_drops_these(clips):
    for clip in clips:
        changes = np.r_[0, np.abs(np.diff(np.asarray(clip.stimulus.frames), axis=0)).mean((1, 2))]
        assert find_repeats(changes)[repeats(clip)].all()


def test_collisions_end_shortly_before_contact_with_a_dark_object_seen_large(of):
    for clip in of["collision"]:
        assert 100 <= clip.time_to_contact_ms[-1] < 500
        assert -0.95 <= clip.stimulus.parameters["contrast"] <= -0.5
        assert clip.stimulus.courses["full_angle_deg"][-1] >= 25 - 1e-6


def test_time_to_contact_is_that_of_the_growing_angle(of):
    """The half angle's tangent by its rate of growth, from pairs of frames (Hoyle 1957; Lee 1976)."""
    for clip in of["collision"]:
        distance = 1 / np.tan(np.radians(np.asarray(clip.stimulus.courses["full_angle_deg"])) / 2)
        distance, left = distance[~repeats(clip)], clip.time_to_contact_ms[~repeats(clip)]
        closing = -np.diff(distance) * shot_fps(clip) / 1000
        assert np.allclose(distance[1:] / closing, left[1:], rtol=1e-6)
        assert np.allclose(distance[:-1] / closing, left[:-1], rtol=1e-6)


def test_time_to_contact_is_that_of_the_measured_area(clips):
    """Under a pinhole one over the side of an image falls in a straight line to zero at contact."""
    plain = [clip for clip in clips if clip.kind == "collision" and "background" in clip.stimulus.parameters]
    assert len(plain) >= 3
    for clip in plain:
        angle, frames = (np.asarray(x) for x in (clip.stimulus.courses["full_angle_deg"], clip.stimulus.frames))
        whole = (angle > 8) & (angle < 16)
        halfway = clip.stimulus.parameters["background"] * (1 + clip.stimulus.parameters["contrast"] / 2)
        side = np.sqrt(np.sum(frames[whole] < float(halfway), axis=(1, 2)))
        left = clip.time_to_contact_ms
        slope, offset = np.polyfit((left[0] - left)[whole], 1 / side, 1)
        assert -offset / slope == pytest.approx(left[0], rel=0.05)


def test_what_is_no_collision_has_no_time_to_contact(clips):
    for clip in clips:
        if clip.kind != "collision":
            assert np.all(clip.time_to_contact_ms == np.inf)


def test_kinds_are_what_they_are_called(of):
    for clip in of["near miss"]:
        distance = 1 / np.tan(np.radians(np.asarray(clip.stimulus.courses["full_angle_deg"])) / 2)
        assert distance.min() >= 2 - 1e-6  # half-sizes
        assert distance.min() < distance[0] / 1.5
    for clip in of["recession"]:
        angle = np.asarray(clip.stimulus.courses["full_angle_deg"])
        assert np.all(np.diff(angle) <= 1e-9)
        assert angle[-1] < angle[0] / 2
    for clip in of["light approach"]:
        angle, level = (
            np.asarray(clip.stimulus.courses["full_angle_deg"]),
            np.asarray(clip.stimulus.frames).mean((1, 2)),
        )
        assert angle[-1] >= 25 - 1e-6
        assert level[-1] > level[0] + 1


def test_every_clip_moves(clips):
    for clip in clips:
        frames = np.asarray(clip.stimulus.frames)
        blocks = frames.reshape(90, 9, 4, 16, 4).mean((2, 4))
        light = blocks.mean((1, 2), keepdims=True)
        assert np.ptp(blocks / light, axis=0).max() > 0.3  # noise makes 0.1 of it


def test_the_same_key_is_the_same_clip_to_the_bit():
    first, again, other = (stimuli.random_encounter(EYE, jax.random.key(seed)) for seed in (5, 5, 6))
    named = stimuli.random_encounter(EYE, jax.random.key(5), kind=first.kind)
    for clip in (again, named):
        assert clip.kind == first.kind
        assert np.array_equal(clip.stimulus.frames, first.stimulus.frames)
        assert np.array_equal(clip.time_to_contact_ms, first.time_to_contact_ms)
    assert not np.array_equal(other.stimulus.frames, first.stimulus.frames)


def test_the_old_name_of_a_random_encounter_still_works():
    eye = Eye(rows=12, cols=20, degrees_per_pixel=5.0, fps=20.0)
    with pytest.warns(DeprecationWarning, match="encounter is called random_encounter now"):
        old = stimuli.encounter(eye, KEY, kind="clutter", duration_ms=500)
    new = stimuli.random_encounter(eye, KEY, kind="clutter", duration_ms=500)
    assert np.array_equal(old.stimulus.frames, new.stimulus.frames)


def test_a_clip_is_the_same_whatever_the_count(clips):
    for count in (1, 2, 5):
        some = list(stimuli.encounters(EYE, KEY, count))
        assert [clip.kind for clip in some].count("collision") == count // 2
        for clip, known in zip(some[: count // 2 * 2], clips, strict=False):
            assert np.array_equal(clip.stimulus.frames, known.stimulus.frames)


def test_half_are_collisions_where_the_kind_is_drawn(monkeypatch):
    def blank(scenario):
        return stimuli.luminance(scenario.eye, **scenario.window(scenario.frames - 1))

    monkeypatch.setattr(_encounter, "camera", lambda stimulus, *_, **__: stimulus)
    monkeypatch.setattr(_encounter, "KINDS", dict.fromkeys(stimuli.ENCOUNTERS, blank))
    kinds = collections.Counter(stimuli.random_encounter(EYE, jax.random.key(seed)).kind for seed in range(400))
    assert kinds["collision"] == pytest.approx(200, abs=40)
    assert all(kinds[kind] == pytest.approx(400 / 12, abs=20) for kind in stimuli.ENCOUNTERS if kind != "collision")


@pytest.mark.parametrize("fps", [4.0, 200.0])
def test_frame_rates_and_durations_are_kept(fps):
    eye = Eye(rows=12, cols=20, degrees_per_pixel=5.0, fps=fps)
    clip = stimuli.random_encounter(eye, KEY, kind="collision", duration_ms=1000)
    assert clip.stimulus.frames.shape == (fps, 12, 20)
    assert clip.stimulus.fps == fps
    assert 100 <= clip.time_to_contact_ms[-1] < 500
    assert np.allclose(np.diff(clip.time_to_contact_ms[~repeats(clip)]), -1000 / shot_fps(clip))


BAD = {
    "kind": (lambda: stimuli.random_encounter(EYE, KEY, kind="colision"), "kind is 'colision'; choose 'collision'"),
    "duration": (lambda: stimuli.random_encounter(EYE, KEY, duration_ms=0), "duration_ms is 0 ms; give a positive"),
    "short": (lambda: stimuli.random_encounter(EYE, KEY, duration_ms=40), "duration_ms is 40 at 30 fps"),
    "slow": (lambda: stimuli.random_encounter(Eye(9, 9, 5.0, 3.0), KEY), "fps is 3; give an eye of more than 3 fps"),
    "pixels": (lambda: stimuli.random_encounter(Eye(9, 9, None, 30.0), KEY), "has no degrees_per_pixel"),
    "count": (lambda: stimuli.encounters(EYE, KEY, 0), "count is 0; give a whole number"),
    "clips' duration": (lambda: stimuli.encounters(EYE, KEY, 2, duration_ms=-1), "duration_ms is -1"),
}


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(("make", "message"), BAD.values(), ids=BAD)
def test_misuse_is_refused_in_one_line(make, message):
    with pytest.raises(ValueError, match=message) as error:
        make()
    assert "\n" not in str(error.value)
