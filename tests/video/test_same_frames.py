"""`respond`, `watch` and a fit of alarms see the same frames of a clip, at the same times."""

import numpy as np
import pytest
import tifffile

import lgmd2jax as lgmd
from lgmd2jax._signals import stretches
from lgmd2jax._video.clip import open_clip
from lgmd2jax.alarms import _decoding as module, evaluate, load_labels, load_recipe
from lgmd2jax.alarms._clip_batch import batches_of
from lgmd2jax.cli.respond import responses
from tests.videos import conversion, loom, noise, write_folder, write_video

pytest.importorskip("av", reason="reading video needs the extra 'video'")

COUNT, ROWS, COLS = 24, 32, 48
LOOM = loom(COUNT, 40, COUNT - 2)
STAMPS = np.cumsum([0, *[40] * 11, 200, *[40] * 10, 1000])
FILE = """
[eye]
rows = 8
cols = 12
degrees_per_pixel = 5
fps = 25

[[clip]]
file = "{}"
"""
RECIPE = """
protocol = "mine.toml"
kind = "alarms"

[free]
T_sp = { low = 0.51, high = 0.97 }
"""


def video(name, codec, pixels, stamps=None, **options):
    return lambda folder: write_video(folder / name, LOOM, codec, pixels, stamps_ms=stamps, **options)


def images(name):
    return lambda folder: write_folder(folder / "frames", LOOM, name)


def stack(folder):
    tifffile.imwrite(
        folder / "stack.tif",
        LOOM[..., 0].astype(np.uint16) * 257,
        byteorder=">",
        photometric="minisblack",
    )
    return folder / "stack.tif"


FORMATS = {
    "mp4": video("c.mp4", "libx264", "yuv420p"),
    "mp4, uneven": video("c.mp4", "libx264", "yuv420p", STAMPS),
    "mkv, uneven": video("c.mkv", "ffv1", "bgr0", STAMPS),
    "mkv, late": video("c.mkv", "libx264", "yuv420p", STAMPS + 9000),
    "webm, uneven": video("c.webm", "libvpx", "yuv420p", STAMPS),
    "mov, upright": video("c.mov", "qtrle", "rgb24", rotation=90),
    "avi": video("c.avi", "mpeg4", "yuv420p"),
    "ts": video("c.ts", "mpeg2video", "yuv420p", rate=25),
    "10 bits": video("c.mkv", "ffv1", "yuv420p10le"),
    "gif": video("c.gif", "gif", "rgb8", rate=20),
    "apng": video("c.apng", "apng", "rgb24"),
    "raw": video("c.mjpeg", "mjpeg", "yuvj420p"),
    "png": images("{}.png"),
    "jpg": images("{}.jpg"),
    "tif": stack,
}


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "cache_folder", lambda: tmp_path / "cache" / "lgmd2jax")


def labelled(folder, path, *lines):
    (folder / "mine.toml").write_text("\n".join([FILE.format(path.name), *lines]))
    (folder / "recipe.toml").write_text(RECIPE)
    return load_labels(folder / "mine.toml")


def assert_same(folder, path, lines=(), **options):
    """Frames, times and intervals of the labelled clip, of the fit's, and of the stream, and what the model answers."""
    file = labelled(folder, path, "silent = [[1, 9]]", *lines)
    clip = open_clip(path, resize=12, **options)
    clip = clip.without_repeats() if "drop_duplicates = true" in lines else clip
    frames = [frame for frame in clip if not frame.repeated]
    model = lgmd.LGMD2()
    rows = [row for frame, row in responses(model, clip) if not frame.repeated]
    # The second time from the cache.
    for (labelled_clip,) in (file.load(), load_recipe(folder / "recipe.toml").file.load()):
        np.testing.assert_array_equal(labelled_clip.frames, [frame.grey for frame in frames])
        np.testing.assert_array_equal(labelled_clip.index, [frame.index for frame in frames])
        np.testing.assert_array_equal(labelled_clip.time, [frame.time for frame in frames])
        np.testing.assert_array_equal(labelled_clip.interval, [frame.interval for frame in frames])
        (batch,) = batches_of([labelled_clip])
        evidence = np.asarray(batch.traces(model, batch.sums(model), N_sp=1))[0]
        # The alarm rests on the largest adapted potential of the last N_ts + 1 frames.
        adapted = np.array([row.smp_adapted for row in rows])
        latest = [adapted[max(0, i - model.N_ts) : i + 1].max() for i in range(len(adapted))]
        np.testing.assert_allclose(evidence, latest, rtol=1e-5)
    (watched,) = file.evaluate(model).clips
    np.testing.assert_array_equal(watched.index, [frame.index for frame in frames])
    np.testing.assert_array_equal(watched.time, [frame.time for frame in frames])
    np.testing.assert_array_equal(watched.interval, [frame.interval for frame in frames])
    return frames


# The upright one is told that its shape is not the eye's.
@pytest.mark.filterwarnings("ignore:.*the model sees 18 x 12 pixels:lgmd2jax._video.remarks.ClipWarning")
@pytest.mark.parametrize("form", FORMATS)
def test_all_see_the_same_frames_at_the_same_times(tmp_path, form):
    path = FORMATS[form](tmp_path)
    told = {"fps": 25} if form in ("raw", "png", "jpg", "tif") else {}
    lines = [f"fps = {told['fps']}"] if told else []
    frames = assert_same(tmp_path, path, lines, **told)
    assert len(frames) == COUNT
    if "uneven" in form or "late" in form:
        np.testing.assert_allclose([frame.time for frame in frames], STAMPS, atol=1)
        np.testing.assert_allclose([frame.interval for frame in frames[1:]], np.diff(STAMPS), atol=1.5)


@pytest.mark.parametrize("stamps", [None, STAMPS], ids=["even", "uneven"])
def test_all_raise_the_same_alarms(tmp_path, stamps):
    """`respond` frame by frame, `watch` in blocks, and a fit on the whole clip."""
    path = write_video(tmp_path / "c.mkv", LOOM, stamps_ms=stamps)
    file, model = labelled(tmp_path, path, "silent = [[1, 9]]"), lgmd.LGMD2(lgmd.preset("lgmd2", T_sp=0.55, k=0.3))
    rows = [row for _, row in responses(model, open_clip(path, resize=12))]
    alarms = tuple(stretches(np.array([row.collision for row in rows]) > 0))
    for evaluation in (file.evaluate(model), evaluate(model, load_recipe(tmp_path / "recipe.toml").file.load())):
        (verdict,) = evaluation.verdicts()
        assert verdict.alarms == alarms != ()


def test_without_repeats_too(tmp_path):
    shown = conversion(20, 30, 30)
    path = write_video(tmp_path / "c.mkv", noise(20, (ROWS, COLS))[shown])
    assert len(assert_same(tmp_path, path, ["drop_duplicates = true"])) == 20


def test_a_frame_that_is_held_is_as_long_for_a_labelled_clip(tmp_path):
    held = [*np.round(np.arange(60) * 100 / 3), 7000]
    pictures = np.concatenate([np.repeat(LOOM[:1], 61 - COUNT, 0), LOOM])
    path = write_video(tmp_path / "c.mp4", pictures, "libx264", "yuv420p", stamps_ms=held)
    (clip,) = labelled(tmp_path, path, "silent = [[0, 34]]").load()
    assert clip.fps == pytest.approx(30, rel=1e-3)
    assert clip.silent_minutes == pytest.approx(35 / 30 / 60, rel=1e-3)
    assert clip.interval[-1] == pytest.approx(7000 - 59 * 100 / 3, abs=1)
