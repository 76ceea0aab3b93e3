"""Reading clips: files and folders, grey levels, windows, clocks, repeated frames, memory."""

import sys
import tracemalloc

import imageio.v3 as iio
import numpy as np
import pytest
from skimage.transform import resize, resize_local_mean

from lgmd2jax._video.clip import open_clip
from lgmd2jax._video.grey import grey
from tests.videos import damaged, noise, write_folder, write_video

av = pytest.importorskip("av", reason="reading video needs the extra 'video'")

FPS = 30.0


# Pictures and grey levels


def test_a_file_comes_back_picture_by_picture_even_with_odd_sizes(tmp_path):
    pictures = noise(5, (25, 33))
    frames = list(open_clip(write_video(tmp_path / "clip.mkv", pictures)))
    assert [frame.index for frame in frames] == [0, 1, 2, 3, 4]
    np.testing.assert_array_equal([frame.picture for frame in frames], pictures)


def test_grey_levels_are_itu_r_601():
    pure = np.array([[[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255], [10, 100, 200]]], np.uint8)
    expected = [[0.299 * 255, 0.587 * 255, 0.114 * 255, 255, 0.299 * 10 + 0.587 * 100 + 0.114 * 200]]
    assert grey(pure).dtype == np.float32
    np.testing.assert_allclose(grey(pure), expected, rtol=1e-6)


def test_a_folder_is_read_in_natural_order(tmp_path):
    pictures = noise(12)
    folder = write_folder(tmp_path / "frames", pictures)
    (folder / "notes.txt").write_text("no image")
    frames = list(open_clip(folder, fps=25))
    np.testing.assert_array_equal([frame.picture for frame in frames], pictures)
    assert [frame.time for frame in frames] == [40.0 * i for i in range(12)]


@pytest.mark.parametrize("kind", ["grey", "grey and alpha", "rgba", "palette", "16 bit", "one bit"])
def test_every_kind_of_image_becomes_8_bit_rgb(tmp_path, kind):
    from PIL import Image

    level = np.array([[0, 0, 255, 255]] * 4, np.uint8)
    colour = np.stack([level, level, level], -1)
    image = {
        "grey": lambda: Image.fromarray(level),
        "grey and alpha": lambda: Image.fromarray(np.stack([level, np.full_like(level, 255)], -1), "LA"),
        "rgba": lambda: Image.fromarray(np.dstack([colour, np.full_like(level, 255)])),
        "palette": lambda: Image.fromarray(colour).convert("P"),
        "16 bit": lambda: Image.fromarray(level.astype(np.uint16) * 257),
        "one bit": lambda: Image.fromarray(level).convert("1"),
    }[kind]()
    folder = tmp_path / "frames"
    folder.mkdir()
    for i in range(2):
        image.save(folder / f"{i}.png")
    for frame in open_clip(folder, fps=FPS):
        np.testing.assert_array_equal(frame.picture, colour)


def test_a_camera_held_upright_is_turned_back(tmp_path):
    pictures = noise(3, (24, 34))
    path = write_video(tmp_path / "clip.mov", pictures, "qtrle", "rgb24", rotation=90)
    clip = open_clip(path)
    assert clip.size == (34, 24)
    np.testing.assert_array_equal([frame.picture for frame in clip], np.rot90(pictures, axes=(1, 2)))


# Windows


def test_the_crop_is_of_rows_and_columns_and_open_ends_reach_the_edge(tmp_path):
    pictures = noise(2)
    path = write_video(tmp_path / "clip.mkv", pictures)
    for window in (np.s_[3:20, 5:30], np.s_[:, 5:], np.s_[:20, :]):
        clip = open_clip(path, crop=window)
        for frame, picture in zip(clip, pictures, strict=True):
            np.testing.assert_array_equal(frame.grey, grey(picture)[window])
            assert frame.grey.shape == clip.shape
            assert frame.picture.shape == picture.shape


@pytest.mark.parametrize("width", [32, 41, 96, 150])
def test_the_resize_gives_a_width_keeps_the_aspect_and_averages_over_areas(tmp_path, width):
    pictures = noise(2, (48, 96))
    clip = open_clip(write_video(tmp_path / "clip.mkv", pictures), resize=width)
    small = next(iter(clip)).grey
    assert small.shape == clip.shape == (round(width / 2), width)
    assert small.dtype == np.float32
    level = grey(pictures[0]).astype(float)
    if width <= 96:
        expected = np.asarray(resize_local_mean(level, clip.shape, grid_mode=True, preserve_range=True))
    else:
        expected = np.asarray(resize(level, clip.shape, order=1, mode="edge", preserve_range=True))
    # The scaler counts in 1/128 of a grey level, and its weights are multiples of 1/16384.
    np.testing.assert_allclose(small, expected, atol=0.1)
    images = open_clip(write_folder(tmp_path / "frames", pictures), fps=FPS, resize=width)
    np.testing.assert_allclose(next(iter(images)).grey, expected, atol=1e-3)


def test_the_crop_comes_before_the_resize(tmp_path):
    clip = open_clip(write_folder(tmp_path / "frames", noise(2, (40, 60))), fps=FPS, crop=np.s_[10:30, :], resize=30)
    assert clip.shape == (10, 30)


# Clocks


@pytest.mark.parametrize("suffix", [".mp4", ".mkv", ".avi"])
def test_a_steady_file_has_the_exact_clock_whatever_its_container_rounds(tmp_path, suffix):
    path = write_video(tmp_path / f"clip{suffix}", noise(20, (32, 32)), "mpeg4", "yuv420p")
    frames = list(open_clip(path))
    assert [frame.time for frame in frames] == [i * 1000 / 30 for i in range(20)]
    assert {frame.interval for frame in frames} == {1000 / 30}


def test_time_stamps_count_where_the_clock_is_not_steady_unless_fps_is_told(tmp_path):
    stamps = [0, 33, 67, 100, 200, 240, 261, 300]
    path = write_video(tmp_path / "clip.mkv", noise(8), stamps_ms=stamps)
    frames = list(open_clip(path))
    np.testing.assert_allclose([frame.time for frame in frames], stamps, atol=1)
    np.testing.assert_allclose([frame.interval for frame in frames][1:], np.diff(stamps), atol=1.5)
    assert [frame.time for frame in open_clip(path, fps=50)] == [20.0 * i for i in range(8)]
    assert {frame.interval for frame in open_clip(path, fps=50)} == {20.0}


# Memory


def test_the_memory_does_not_grow_with_the_length_of_the_clip(tmp_path, usual_gc):
    def peak(count):
        path = write_video(tmp_path / f"{count}.avi", noise(4, (120, 160))[np.arange(count) % 4], "mpeg4", "yuv420p")
        clip = open_clip(path, resize=40)
        tracemalloc.start()
        assert sum(1 for _ in clip.without_repeats()) == count
        top = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return top

    peak(10)
    assert peak(200) < peak(20) + 2 * 120 * 160 * 3


# Bad input


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("clip.mp4", {"codec": "libx264", "pixels": "yuv420p"}),
        ("clip.mkv", {"codec": "libx264", "pixels": "yuv420p"}),
        ("clip.avi", {"codec": "mpeg4", "pixels": "yuv420p"}),
        ("clip.mov", {"codec": "qtrle", "pixels": "rgb24"}),
    ],
)
def test_a_truncated_file_is_refused(tmp_path, name, options):
    path = write_video(tmp_path / name, noise(90, (48, 64)), **options)
    assert sum(1 for _ in open_clip(path)) == 90
    with pytest.raises(ValueError, match="truncated"):
        list(open_clip(damaged(path)))


def test_a_truncated_file_that_decodes_some_frames_is_refused_at_its_end(tmp_path):
    path = tmp_path / "clip.mp4"
    with av.open(str(path), "w", options={"movflags": "faststart"}) as container:
        stream = container.add_stream("libx264", rate=30, width=64, height=48, pix_fmt="yuv420p")
        for picture in noise(90, (48, 64)):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture)))
        container.mux(stream.encode(None))
    seen = []
    with pytest.raises(ValueError, match=r"truncated: .*; .*--until-damage"):
        seen.extend(frame.index for frame in open_clip(damaged(path)))
    assert 20 < len(seen) < 90


def test_what_is_no_clip_is_refused(tmp_path):
    (tmp_path / "empty.mp4").touch()
    (tmp_path / "noise.mp4").write_bytes(np.random.default_rng(0).bytes(5000))
    (tmp_path / "text.txt").write_text("hello\n" * 100)
    (tmp_path / "folder").mkdir()
    for name, message in {
        "empty.mp4": "is not a video, or is truncated",
        "noise.mp4": "is not a video, or is truncated",
        "text.txt": "holds no video",
        "folder": "holds no image",
    }.items():
        with pytest.raises(ValueError, match=message):
            open_clip(tmp_path / name, fps=FPS)
    with pytest.raises(FileNotFoundError, match="no such clip"):
        open_clip(tmp_path / "missing.mp4")


def test_a_sound_file_is_refused(tmp_path):
    path = tmp_path / "sound.wav"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("pcm_s16le", rate=8000, layout="mono")
        silence = av.AudioFrame.from_ndarray(np.zeros((1, 8000), np.int16), layout="mono")
        silence.sample_rate = 8000
        container.mux(stream.encode(silence))
    with pytest.raises(ValueError, match="holds no video"):
        open_clip(path)


def test_options_that_do_not_fit_are_refused(tmp_path):
    folder = write_folder(tmp_path / "frames", noise(3))
    for options, message in [
        ({}, "states no frame rate"),
        ({"fps": 0.0}, "fps is 0"),
        ({"fps": -5.0}, "fps is -5"),
        ({"fps": float("nan")}, "fps is nan"),
        ({"fps": FPS, "crop": np.s_[0:25, :]}, r"crop 0:25,: does not lie in the frame; its rows are 0:24"),
        ({"fps": FPS, "crop": np.s_[:, 40:]}, "does not lie in the frame"),
        ({"fps": FPS, "crop": np.s_[9:9, :]}, "does not lie in the frame"),
        ({"fps": FPS, "crop": np.s_[:2, :]}, "2 x 33 pixels after crop and resize; the network needs at least 3 x 3"),
        ({"fps": FPS, "resize": 3}, "2 x 3 pixels"),
        ({"fps": FPS, "resize": 0}, "0 x 0 pixels"),
    ]:
        with pytest.raises(ValueError, match=message):
            open_clip(folder, **options)


def test_images_of_different_sizes_are_refused_by_name(tmp_path):
    folder = write_folder(tmp_path / "frames", noise(3))
    iio.imwrite(folder / "3.png", noise(1, (24, 32))[0])
    with pytest.raises(ValueError, match="frame 3 has 24 x 32 pixels, the first 24 x 33"):
        list(open_clip(folder, fps=FPS))


def test_a_broken_image_is_refused_by_name(tmp_path):
    folder = write_folder(tmp_path / "frames", noise(3))
    damaged(folder / "1.png")
    with pytest.raises(ValueError, match=r"cannot read .*1\.png as an image"):
        list(open_clip(folder, fps=FPS))


def test_a_single_frame_is_refused(tmp_path):
    with pytest.raises(ValueError, match="one frame"):
        list(open_clip(write_folder(tmp_path / "frames", noise(1)), fps=FPS))


def test_without_pyav_the_message_says_how_to_get_it(tmp_path, monkeypatch):
    path = write_video(tmp_path / "clip.mkv", noise(2))
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(ValueError, match=r"pip install 'lgmd2jax\[video\]'"):
        open_clip(path)
