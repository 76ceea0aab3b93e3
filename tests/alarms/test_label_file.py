"""Files of labelled clips: what they say, what follows where they say nothing, and what is refused."""

import shutil

import numpy as np
import pytest

from lgmd2jax._video.clip import open_clip
from lgmd2jax._video.remarks import ClipWarning
from lgmd2jax.alarms import Rendering, _decoding as module, load_labels
from tests.videos import damaged, noise, write_folder, write_video

EYE = """
[eye]
rows = 9
cols = 12
degrees_per_pixel = 5
fps = 30
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with a clip of 60 frames, every sixth a repeat, and a cache of its own."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(module, "cache_folder", lambda: tmp_path / "cache" / "lgmd2jax")
    pictures = noise(60)
    pictures[5::6] = pictures[4::6]
    write_video(tmp_path / "crash.mkv", list(pictures))
    return tmp_path


def load(place, text):
    (place / "mine.toml").write_text(EYE + text)
    return load_labels(place / "mine.toml").load()


def test_a_clip_and_its_labels(place):
    (clip,) = load(
        place,
        """
[[clip]]
file = "crash.mkv"
drop_duplicates = true
alarm = [[40, 50]]
silent = [[10, 30]]
contact = 48
""",
    )
    assert clip.frames.shape == (50, 9, 12)
    assert clip.fps == pytest.approx(25)
    assert set(range(60)) - set(clip.index.tolist()) == set(range(5, 60, 6))
    assert clip.in_windows().sum() == sum(i % 6 != 5 for i in range(40, 51))
    assert clip.in_silence().sum() == sum(i % 6 != 5 for i in range(10, 31))
    assert clip.contact_ms == pytest.approx(1600)


def test_without_a_silence_all_else_is_silent_but_the_beginning_and_the_time_after_contact(place):
    (clip,) = load(
        place, '[[clip]]\nfile = "crash.mkv"\ncontact = 35\nbefore_ms = [500, 100]\ngrace_ms = 400\nsettle = 4\n'
    )
    assert clip.windows == ((20, 32),)  # 500 and 100 ms are 15 and 3 frames
    assert clip.silent == ((4, 19), (33, 34), (48, 59))
    (quiet,) = load(place, '[[clip]]\nfile = "crash.mkv"\n')
    assert quiet.silent == ((10, 59),)


def test_contact_may_lie_beyond_the_end(place):
    (clip,) = load(place, '[[clip]]\nfile = "crash.mkv"\ncontact = 65\nbefore_ms = [500, 0]\n')
    assert clip.windows == ((50, 59),)  # contact is at 65 / 30 s, the last frame at 59 / 30
    assert clip.silent == ((10, 49),)
    assert clip.contact_ms == pytest.approx(65 / 30 * 1000)


def test_source_and_weight(place):
    text = '[[clip]]\nfile = "crash.mkv"\n'
    clips = load(place, f'{text}name = "a"\n{text}name = "b"\nsource = "mine"\nweight = 2.5\n[rendered]\ncount = 1\n')
    assert [(clip.source, clip.weight) for clip in clips] == [("a", 1), ("mine", 2.5), (None, 1)]


def test_a_clip_is_decoded_once_and_again_when_it_changes(place, monkeypatch):
    text = '[[clip]]\nfile = "crash.mkv"\n'
    (first,) = load(place, text)
    monkeypatch.setattr("lgmd2jax._video.clip.Clip.record", lambda *_: pytest.fail("decoded again"))
    (second,) = load(place, text)
    np.testing.assert_array_equal(first.frames, second.frames)
    monkeypatch.undo()
    write_video(place / "crash.mkv", list(noise(60, seed=1)))
    (third,) = load(place, text)
    assert not np.array_equal(first.frames, third.frames)


def test_labels_count_the_frames_of_the_file_also_where_the_last_ones_repeat(place):
    pictures = noise(40)
    pictures[[5, 11, 17, 23, 29, 35, 39]] = pictures[[4, 10, 16, 22, 28, 34, 38]]
    write_video(place / "crash.mkv", list(pictures))
    (clip,) = load(place, '[[clip]]\nfile = "crash.mkv"\ndrop_duplicates = true\nalarm = [[30, 39]]\ncontact = 39\n')
    assert 39 not in clip.index
    assert clip.in_windows().sum() == 8
    with pytest.raises(ValueError, match="alarm 30 to 40 lies outside of the clip, whose frames are 0 to 39"):
        load(place, '[[clip]]\nfile = "crash.mkv"\ndrop_duplicates = true\nalarm = [[30, 40]]\n')


def test_the_labels_of_all_clips_are_checked_before_any_is_decoded(place, monkeypatch):
    monkeypatch.setattr("lgmd2jax._video.clip.Clip.record", lambda *_: pytest.fail("decoded"))
    write_folder(place / "frames", noise(12))
    text = """
[[clip]]
file = "crash.mkv"
alarm = [[30, 20]]
[[clip]]
file = "frames"
fps = 30
name = "second"
silent = [[5, 12]]
[[clip]]
file = "frames"
fps = 30
name = "third"
before_ms = [500, 0]
"""
    with pytest.raises(
        ValueError, match=r"crash: alarm 30 to 20 is reversed.*second: silent 5 to 12 lies outside.*third: before_ms"
    ):
        load(place, text)


def test_labels_beyond_the_end_show_before_decoding_where_the_file_announces_no_count(place, monkeypatch):
    assert open_clip(place / "crash.mkv").count is None
    monkeypatch.setattr("lgmd2jax._video.clip.Clip.record", lambda *_: pytest.fail("decoded"))
    with pytest.raises(ValueError, match="silent 50 to 60 lies outside of the clip, whose frames are 0 to 59"):
        load(place, '[[clip]]\nfile = "crash.mkv"\nsilent = [[50, 60]]\n')


def test_a_cache_that_cannot_be_written_or_is_broken_is_done_without(place):
    text = '[[clip]]\nfile = "crash.mkv"\n'
    (first,) = load(place, text)
    (kept,) = (place / "cache").rglob("*.npz")
    kept.write_bytes(kept.read_bytes()[:100])
    (again,) = load(place, text)
    np.testing.assert_array_equal(first.frames, again.frames)
    shutil.rmtree(place / "cache")
    (place / "cache").write_text("in the way, as a cache that is read only would be")
    with pytest.warns(ClipWarning, match="decoded again in every run, since the cache .* cannot be written"):
        (again,) = load(place, text)
    np.testing.assert_array_equal(first.frames, again.frames)


def test_a_white_level_and_a_damaged_end_are_keys_of_a_clip(place):
    deep = np.random.default_rng(0).integers(0, 4096, (30, 24, 36), dtype=np.uint16)
    path = write_video(place / "deep.mkv", deep, pixels="gray16le", given="gray16le")
    (clip,) = load(place, '[[clip]]\nfile = "deep.mkv"\nwhite = 4095\n')
    assert clip.frames.mean() == pytest.approx(255 / 2, rel=0.01)
    damaged(path)
    with pytest.warns(ClipWarning, match="damaged or truncated"):
        (clip,) = load(place, '[[clip]]\nfile = "deep.mkv"\nwhite = 4095\nuntil_damage = true\n')
    assert 5 < len(clip.frames) < 30


def test_a_folder_of_images_and_a_crop(place):
    write_folder(place / "frames", noise(12))
    (clip,) = load(place, '[[clip]]\nname = "f"\nfile = "frames"\nfps = 20\ncrop = ":,0:22"\nresize = 11\n')
    assert clip.name == "f"
    assert clip.frames.shape == (12, 12, 11)
    assert clip.fps == 20


def test_the_shipped_file_and_rendered_clips():
    file = load_labels("video")
    assert file.clips == ()
    assert file.rendered is not None
    assert file.rendered == Rendering(file.rendered.count, world="films", alarm_below_ms=850, silent_above_ms=2000)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "mine.toml: there are no clips; list recorded ones under"),
        ('[[clip]]\nfile = "other.mp4"\n', r"clip\[0\]\.file: there is no .*other.mp4; give a path from"),
        ("[[clip]]\nalarm = [[1, 2]]\n", r"clip\[0\]\.file is missing"),
        ('[[clip]]\nfile = "crash.mkv"\nwindows = [[1, 2]]\n', r"clip\[0\]\.windows = .*: unknown key; did you mean"),
        ('[[clip]]\nfile = "crash.mkv"\nalarm = [[50, 70]]\n', "crash: alarm 50 to 70 lies outside of the clip"),
        ('[[clip]]\nfile = "crash.mkv"\nalarm = [[50, 40]]\n', "crash: alarm 50 to 40 is reversed"),
        (
            '[[clip]]\nfile = "crash.mkv"\nalarm = [[20, 30]]\nsilent = [[25, 40]]\n',
            "alarm up to 30 and silent from 25",
        ),
        ('[[clip]]\nfile = "crash.mkv"\nalarm = [[30, 40]]\ncontact = 4\n', "contact is frame 4, before an alarm"),
        ('[[clip]]\nfile = "crash.mkv"\nbefore_ms = [500, 0]\n', "before_ms counts back from contact, which is"),
        ('[[clip]]\nfile = "crash.mkv"\ncontact = 40\nbefore_ms = [0, 500]\n', "give two times before contact"),
        (
            '[[clip]]\nfile = "crash.mkv"\ncontact = 90\nbefore_ms = [500, 0]\n',
            "the clip ends 1033 ms before contact; give a longer time",
        ),
        ('[[clip]]\nfile = "crash.mkv"\nweight = 0\n', r"clip\[0\]\.weight = 0: must be above 0"),
        ('[[clip]]\nfile = "crash.mkv"\nsource = 3\n', r"clip\[0\]\.source = 3: must be a text"),
        ('[[clip]]\nfile = "crash.mkv"\nalarm = [[1, 2]]\nbefore_ms = [9, 0]\n', "alarm and before_ms are both given"),
        ("[rendered]\ncount = 0\n", r"rendered\.count = 0: must be 1 or more"),
        ('[[clip]]\nfile = "crash.mkv"\nalarm = -1\n', r"clip\[0\]\.alarm = -1: must be a list"),
        ('[[clip]]\nfile = "crash.mkv"\nalarm = [1, 2]\n', r"clip\[0\]\.alarm\[0\] = 1: must be a list"),
        ('[[clip]]\nfile = "crash.mkv"\nfps = [true]\n', r"clip\[0\]\.fps = \[True\]: must be a number"),
        ('[[clip]]\nfile = "crash.mkv"\ncrop = {}\n', r"clip\[0\]\.crop = \{\}: must be a text"),
        ('[[clip]]\nfile = "crash.mkv"\nresize = 1e9\n', r"clip\[0\]\.resize = 1.*: must be a whole number"),
        ('[[clip]]\nfile = "crash.mkv"\nuntil_damage = 1\n', r"clip\[0\]\.until_damage = 1: must be true or false"),
        (
            "[rendered]\ncount = 4\nalarm_below_ms = 3000\n",
            "give positive times, the first at most as long as the second",
        ),
    ],
)
def test_what_is_refused(place, text, message):
    with pytest.raises(ValueError, match=message):
        load(place, text)


def test_a_clip_of_unknown_frame_rate(place):
    write_folder(place / "frames", noise(12))
    with pytest.raises(ValueError, match="frames states no frame rate; give it: fps = 30"):
        load(place, '[[clip]]\nfile = "frames"\n')
