"""What is named where a file is wanted, and is none: the error comes at once and says what to give."""

import os

import pytest

import lgmd2jax as lgmd

READERS = {
    "recipe": lgmd.load_recipe,
    "recipe of alarms": lgmd.alarms.load_recipe,
    "protocol": lgmd.load_protocol,
    "labels": lgmd.alarms.load_labels,
    "model": lgmd.load,
    "urgency": lgmd.alarms.load_urgency,
    "fit": lgmd.load_fit,
    "curve": lambda path: lgmd.read_target(path, column="rate", channel="rate"),
    "spikes": lgmd.read_spike_trains,
    "trials": lgmd.load_trials,
    "fits": lambda path: lgmd.compare([path, path]),
}


@pytest.fixture
def place(tmp_path, monkeypatch):
    (tmp_path / "folder").mkdir()
    (tmp_path / "empty").touch()
    (tmp_path / "other").write_bytes(bytes(range(256)))
    os.mkfifo(tmp_path / "pipe")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", ["folder", "folder/", "empty", "empty/", "other", "pipe", "nowhere/file", ""])
@pytest.mark.parametrize("reader", READERS.values(), ids=READERS)
def test_what_is_no_such_file_is_refused_in_one_line(place, reader, name):
    with pytest.raises((ValueError, OSError)) as error:
        reader(name)
    assert "\n" not in str(error.value)
    assert (name.rstrip("/") or "is ''; give") in str(error.value)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("", r"clip\[0\].file is ''; give a video, or a folder of pictures"),
        (" ", r"clip\[0\].file is ' '; give a video, or a folder of pictures"),
        ("folder", "folder holds no image"),
        ("empty", "empty is not a video"),
        ("other", "other is not a video"),
        ("pipe", "no such clip: .*pipe; give a video file or a folder of images"),
        ("nowhere", "there is no .*nowhere"),
    ],
)
def test_a_clip_that_is_none_is_refused(place, name, message):
    eye = "rows = 12\ncols = 16\ndegrees_per_pixel = 4.0\nfps = 30.0"
    (place / "labels.toml").write_text(f"[eye]\n{eye}\n[[clip]]\nfile = '{name}'\nalarm = [[1, 2]]\n")
    with pytest.raises(ValueError, match=message):
        lgmd.alarms.load_labels(place / "labels.toml").load()
