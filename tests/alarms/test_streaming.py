"""A clip that is judged while it is decoded, against the evaluation of the whole clip in memory."""

import dataclasses
import tracemalloc

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.alarms import _decoding, _streaming, evaluate, load_labels
from tests.videos import conversion, loom, noise, write_video

pytest.importorskip("av", reason="reading video needs the extra 'video'")

ROWS, COLS, COUNT = 32, 48, 70
LOOM = loom(COUNT, 60, COUNT - 5)
STAMPS = np.cumsum([0, *[40] * 30, 200, *[40] * 37, 1000])
MODEL = lgmd.LGMD2(lgmd.preset("lgmd2", T_sp=0.65, k=0.5))
MECHANISMS = dataclasses.replace(MODEL, mechanisms=("size", "shunt", "lag", "membrane", "rate"))
LABELS = """
[eye]
rows = 8
cols = 12
degrees_per_pixel = 5
fps = 25

[[clip]]
file = "c.mkv"
alarm = [[40, 60]]
{}
"""


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setattr(_decoding, "cache_folder", lambda: tmp_path / "cache")


def label_file(folder, pictures, *lines, stamps=None):
    write_video(folder / "c.mkv", pictures, stamps_ms=stamps)
    (folder / "mine.toml").write_text(LABELS.format("\n".join(lines)))
    return load_labels(folder / "mine.toml")


def assert_same(file, model=MODEL):
    """Both evaluations to the bit; returns the one from the stream."""
    streamed, whole = file.evaluate(model), evaluate(model, file.load())
    for clip, other in zip(streamed.clips, whole.clips, strict=True):
        for field in dataclasses.fields(clip):
            np.testing.assert_array_equal(getattr(clip, field.name), getattr(other, field.name))
    for trace, other in zip(streamed.evidence, whole.evidence, strict=True):
        assert trace.dtype == other.dtype
        np.testing.assert_array_equal(trace, other)
    for drive, other in zip(streamed.drives, whole.drives, strict=True):
        for channel, same in zip(drive, other, strict=True):
            np.testing.assert_allclose(channel, same, rtol=1e-6)
    assert streamed.T_sp == whole.T_sp
    assert streamed.score() == whole.score()
    assert np.ptp(streamed.evidence[0]) > 0.05  # the model saw the clip
    return streamed


@pytest.mark.parametrize("block", [2, 7, COUNT - 1, COUNT, COUNT + 1, 64])
@pytest.mark.parametrize("model", [MODEL, MECHANISMS], ids=["plain", "mechanisms"])
def test_blocks_of_any_length(tmp_path, monkeypatch, block, model):
    monkeypatch.setattr(_streaming, "_BLOCK", block)
    assert_same(label_file(tmp_path, LOOM), model)


@pytest.mark.parametrize(
    "lines",
    [["resize = 24"], ['crop = "4:28,8:40"', "resize = 16"], ["contact = 66"], ["contact = 66", "silent = [[0, 9]]"]],
    ids=" ".join,
)
@pytest.mark.parametrize("stamps", [None, STAMPS], ids=["even", "uneven"])
def test_crop_resize_labels_and_clock(tmp_path, lines, stamps):
    assert_same(label_file(tmp_path, LOOM, *lines, stamps=stamps))


def test_repeated_frames_are_dropped(tmp_path):
    shown = conversion(30, 40, 80)
    file = label_file(tmp_path, noise(60, (ROWS, COLS))[shown], "drop_duplicates = true", "settle = 3")
    (clip,) = assert_same(file).clips
    assert len(clip.index) == 60 < len(shown)


def test_rendered_clips_follow_the_recorded_ones(tmp_path):
    evaluation = assert_same(label_file(tmp_path, LOOM, "", "[rendered]", "count = 2"))
    assert [clip.name[:3] for clip in evaluation.clips] == ["c", "000", "001"]


def test_memory_does_not_hold_the_clip(tmp_path, usual_gc):
    pictures = noise(600, (ROWS, COLS))
    file = label_file(tmp_path, pictures, f"resize = {COLS}")
    file.evaluate(MODEL)  # compiles
    tracemalloc.start()
    try:
        file.evaluate(MODEL)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < len(pictures) * ROWS * COLS * 4 / 2
