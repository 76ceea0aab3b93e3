"""Video files: clocks, orientation, aspect, depth, what is announced, and damage."""

import itertools
import shutil
import struct
import subprocess
from fractions import Fraction

import numpy as np
import pytest

from lgmd2jax._video.clip import open_clip
from lgmd2jax._video.grey import area_average, grey
from lgmd2jax._video.remarks import ClipWarning
from tests.videos import damaged, noise, write_video

av = pytest.importorskip("av", reason="reading video needs the extra 'video'")

WEIGHTS = np.array([0.299, 0.587, 0.114])


# Clocks


def test_the_default_rate_of_a_raw_stream_is_not_its_own(tmp_path):
    motion = write_video(tmp_path / "raw.mjpeg", noise(6), "mjpeg", "yuvj420p", rate=90)
    with pytest.raises(ValueError, match=r"raw\.mjpeg states no frame rate; give it"):
        open_clip(motion)
    assert [frame.time for frame in open_clip(motion, fps=50)] == [20.0 * i for i in range(6)]


def test_a_raw_stream_that_states_its_rate_has_it(tmp_path):
    frames = list(open_clip(write_video(tmp_path / "raw.h264", noise(6, (32, 48)), "libx264", "yuv420p", rate=90)))
    np.testing.assert_allclose([frame.time for frame in frames], np.arange(6) * 1000 / 90)


def test_a_title_that_is_not_utf_8_does_not_matter(tmp_path):
    path = write_video(tmp_path / "old.mkv", noise(5), setup=lambda stream: stream.metadata.update(title="Strasse"))
    content = path.read_bytes()
    assert b"Strasse" in content
    path.write_bytes(content.replace(b"Strasse", b"Stra\xdfe "))  # Latin-1, as older cameras write
    assert len(list(open_clip(path))) == 5


def test_one_frame_that_is_held_does_not_change_the_rate_of_the_others(tmp_path):
    stamps = [*np.round(np.arange(60) * 1000 / 30), 7000]
    clip = open_clip(write_video(tmp_path / "clip.mp4", noise(61, (32, 48)), "libx264", "yuv420p", stamps_ms=stamps))
    assert clip.fps == pytest.approx(30, rel=1e-3)
    frames = list(clip)
    np.testing.assert_allclose([frame.time for frame in frames], stamps, atol=1)
    np.testing.assert_allclose([frame.interval for frame in frames[:-1]], 1000 / 30, atol=1)
    assert frames[-1].interval == pytest.approx(7000 - 59 * 1000 / 30, abs=1)


@pytest.mark.parametrize("count", [3, 4, 12, 13])
def test_intervals_that_take_turns_have_the_rate_of_one_of_them(tmp_path, count):
    """Between as many short as long ones lies no interval at all, and the rate of such a clip was NaN."""
    stamps = np.cumsum([0, *np.resize([40, 20], count - 1)])
    clip = open_clip(write_video(tmp_path / "clip.mkv", noise(count), stamps_ms=stamps))
    assert clip.fps == pytest.approx(25) or clip.fps == pytest.approx(50)
    np.testing.assert_allclose([frame.time for frame in clip], stamps)


def test_an_interval_given_as_a_rate_is_said(tmp_path):
    with pytest.warns(ClipWarning, match="fps is 0.04; were 25 frames per second meant, given as an interval in s"):
        open_clip(write_video(tmp_path / "clip.mkv", noise(3)), fps=0.04)


@pytest.mark.parametrize("suffix", [".mkv", ".webm", ".ts", ".mp4"])
def test_a_file_need_not_start_at_0(tmp_path, suffix):
    codec = "libvpx" if suffix == ".webm" else "libx264"
    stamps = np.arange(60) * 40 + 20_000
    path = write_video(tmp_path / f"clip{suffix}", noise(60, (32, 48)), codec, "yuv420p", stamps_ms=stamps)
    np.testing.assert_allclose([frame.time for frame in open_clip(path)], stamps - 20_000, atol=1)


# Windows, turns and mirrors


@pytest.mark.parametrize(
    ("turn", "hflip", "vflip"), [*itertools.product([0, 90, 180, 270], [False, True], [False, True])]
)
def test_a_display_matrix_turns_and_mirrors_also_windows(tmp_path, turn, hflip, vflip):
    def setup(stream):
        if not hasattr(stream, "set_display_matrix"):
            pytest.skip("this version of PyAV cannot write display matrices")
        stream.set_display_rotation(turn, hflip=hflip, vflip=vflip)

    stored = noise(2, (24, 34))
    path = write_video(tmp_path / "clip.mov", stored, "qtrle", "rgb24", setup=setup)
    shown = np.rot90(stored[0], turn // 90)
    shown = shown[:, ::-1] if hflip else shown
    shown = shown[::-1] if vflip else shown
    first = next(iter(open_clip(path)))
    np.testing.assert_array_equal(first.picture, shown)
    window = np.s_[3:20, 4:17]
    np.testing.assert_allclose(next(iter(open_clip(path, crop=window))).grey, grey(shown[window]), atol=1e-4)
    small = next(iter(open_clip(path, crop=window, resize=6)))
    np.testing.assert_allclose(small.grey, area_average(grey(shown[window]), (8, 6)), atol=0.1)


def test_another_angle_is_refused(tmp_path):
    path = write_video(tmp_path / "clip.mov", noise(2), "qtrle", "rgb24", rotation=30)
    with pytest.raises(ValueError, match=r"clip\.mov is to be shown at an angle that is no multiple of 90"):
        open_clip(path)


@pytest.mark.parametrize(("turn", "shape"), [(0, (18, 32)), (90, (57, 32))])
def test_the_aspect_of_pixels_is_said_and_undone_by_a_resize(tmp_path, turn, shape):
    def setup(stream):
        stream.codec_context.sample_aspect_ratio = Fraction(4, 3)
        if turn and not hasattr(stream, "set_display_rotation"):
            pytest.skip("this version of PyAV reads rotated video but cannot write it")
        if turn:
            stream.set_display_rotation(turn)

    path = write_video(tmp_path / "clip.mp4", noise(2, (24, 32)), "libx264", "yuv420p", setup=setup)
    with pytest.warns(ClipWarning, match=r"are taken for square; resize would"):
        assert sorted(open_clip(path).shape) == [24, 32]
    with pytest.warns(ClipWarning, match=r"times as wide as high, and are made square"):
        assert open_clip(path, resize=32).shape == shape


def test_interlacing_is_said(tmp_path):
    path = write_video(tmp_path / "clip.mpg", noise(6, (48, 64)), "mpeg2video", "yuv420p", flags="+ilme+ildct")
    with pytest.warns(ClipWarning, match="it is interlaced"):
        open_clip(path)


@pytest.mark.parametrize(("curve", "name"), [("smpte2084", "PQ"), ("arib-std-b67", "HLG")])
def test_a_wide_range_of_light_is_said(tmp_path, curve, name):
    """As phones film by default: such levels are no usual grey levels."""

    def setup(stream):
        stream.codec_context.options = {"x264-params": f"transfer={curve}"}

    path = write_video(tmp_path / "phone.mp4", noise(3, (32, 48)), "libx264", "yuv420p", setup=setup)
    with pytest.warns(ClipWarning, match=rf"its levels are coded for HDR \({name}\), in which contrasts are others"):
        open_clip(path)


def test_a_second_video_is_said(tmp_path):
    path = tmp_path / "clip.mkv"
    with av.open(str(path), "w") as container:
        streams = [container.add_stream("ffv1", rate=30, width=24, height=16, pix_fmt="bgr0") for _ in range(2)]
        for i, (stream, level) in itertools.product(range(4), zip(streams, (50, 200), strict=True)):
            frame = av.VideoFrame.from_ndarray(np.full((16, 24, 3), level, np.uint8))
            frame.pts = i
            container.mux(stream.encode(frame))
        for stream in streams:
            container.mux(stream.encode(None))
    with pytest.warns(ClipWarning, match="it holds 2 videos; the first is used"):
        clip = open_clip(path)
    assert [round(float(frame.grey.mean())) for frame in clip] == [50] * 4


# Grey levels


def planes(path):
    """The planes of the first frame, as numbers, and its format."""
    with av.open(str(path)) as container:
        frame = next(container.decode(video=0))
        dtype = np.uint16 if frame.format.components[0].bits > 8 else np.uint8
        rows = [np.frombuffer(plane, dtype).reshape(plane.height, -1)[:, : plane.width] for plane in frame.planes]
        return [row.astype(float) for row in rows], frame.format.name


@pytest.mark.parametrize("pixels", ["yuv420p", "yuv444p", "yuvj420p", "yuv420p10le", "yuv422p12le"])
def test_scaled_grey_levels_are_those_of_the_standard(tmp_path, pixels):
    y, x = np.mgrid[:48, :64]
    smooth = np.stack([120 + 90 * np.sin(x / 9 + c) * np.cos(y / 11 + c) for c in range(3)], -1).astype(np.uint8)
    codec = "mjpeg" if pixels == "yuvj420p" else "ffv1"
    path = write_video(tmp_path / "clip.mkv", [smooth] * 2, codec, pixels)
    small = next(iter(open_clip(path, resize=16))).grey
    (luma, blue, red), name = planes(path)
    # BT.601, applied to the averages of the planes: conversion and averaging are both linear.
    unit = 2 ** (av.VideoFormat(name).components[0].bits - 8)
    luma, blue, red = (area_average(plane / unit, (12, 16)) for plane in (luma, blue, red))
    full = "j" in name
    luma = luma if full else (luma - 16) * 255 / 219
    blue, red = ((plane - 128) * (1 if full else 255 / 224) for plane in (blue, red))
    colours = [luma + 1.402 * red, luma - 0.344136 * blue - 0.714136 * red, luma + 1.772 * blue]
    np.testing.assert_allclose(small, np.clip(np.stack(colours, -1), 0, 255) @ WEIGHTS, atol=0.1)


@pytest.mark.parametrize("resize", [None, 11])
def test_grey_video_of_16_bits_keeps_them_and_takes_a_white_level(tmp_path, resize):
    values = np.random.default_rng(0).integers(0, 4096, (2, 24, 33), dtype=np.uint16)
    path = write_video(tmp_path / "clip.mkv", values, pixels="gray16le", given="gray16le")
    with pytest.warns(ClipWarning, match="if the camera gives 12 bits, give it: white = 4095"):
        dark = next(iter(open_clip(path, resize=resize)))
    right = next(iter(open_clip(path, resize=resize, white=4095)))
    expected = area_average(values[0].astype(float), right.grey.shape)
    np.testing.assert_allclose(dark.grey, expected / 257, atol=0.02)
    np.testing.assert_allclose(right.grey, expected * 255 / 4095, atol=0.3)
    if resize is None:
        np.testing.assert_allclose(right.picture[..., 0], values[0] * (255 / 4095), atol=0.6)
    with pytest.raises(ValueError, match="above white = 1000"):
        open_clip(path, white=1000)


def test_a_white_level_of_video_that_states_its_own_is_refused(tmp_path):
    path = write_video(tmp_path / "clip.mp4", noise(3, (32, 32)), "libx264", "yuv420p")
    with pytest.raises(ValueError, match="white is 4095, but yuv420p states its own"):
        open_clip(path, white=4095)


@pytest.mark.parametrize("pixels", ["bgra", "yuva444p"])
def test_transparent_video_is_laid_on_white_and_said(tmp_path, pixels):
    picture = np.full((16, 24, 4), 40, np.uint8)
    picture[..., 3] = np.where(np.arange(24) < 12, 255, 0)
    path = write_video(tmp_path / "clip.mkv", [picture] * 3, pixels=pixels, given="rgba")
    with pytest.warns(ClipWarning, match="it is transparent in places, and is shown on white"):
        clip = open_clip(path, resize=12)
    np.testing.assert_allclose(next(iter(clip)).grey, np.where(np.arange(12) < 6, 40, 255) * np.ones((8, 1)), atol=1.5)


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
@pytest.mark.parametrize("suffix", [".mp4", ".mkv", ".avi"])
def test_ffmpeg_says_the_same_of_grey_levels_and_time_stamps(tmp_path, suffix):
    codec = "mpeg4" if suffix == ".avi" else "libx264"
    stamps = None if suffix == ".avi" else np.cumsum([0, 33, 34, 33, 90, 40, 33, 150, 33])
    # Of one hue: ffmpeg's versions differ in where they take colour to be sampled.
    blocks = np.kron(noise(9, (6, 8))[..., :1], np.ones((1, 8, 8, 1), np.uint8))
    pictures = np.round(blocks * [1.0, 0.9, 0.8]).astype(np.uint8)
    path = write_video(tmp_path / f"clip{suffix}", pictures, codec, "yuv420p", stamps_ms=stamps)
    filters = ["-vf", "scale=16:12:flags=area+accurate_rnd+full_chroma_int", "-pix_fmt", "rgb24", "-f", "rawvideo", "-"]
    command = ["ffmpeg", "-v", "error", "-i", str(path), "-fps_mode", "passthrough", *filters]
    raw = subprocess.run(command, check=True, capture_output=True).stdout
    expected = np.frombuffer(raw, np.uint8).reshape(-1, 12, 16, 3) @ WEIGHTS
    probe = ["ffprobe", "-v", "error", "-select_streams", "v", "-show_entries", "frame=best_effort_timestamp_time"]
    times = subprocess.run([*probe, "-of", "csv=p=0", str(path)], check=True, capture_output=True, text=True).stdout
    seconds = np.array([float(line.strip(",")) for line in times.split()])
    frames = list(open_clip(path, resize=16))
    np.testing.assert_allclose([frame.grey for frame in frames], expected, atol=0.75)  # ffmpeg rounds each colour
    np.testing.assert_allclose([frame.time for frame in frames], 1000 * (seconds - seconds[0]), atol=1)


# What is announced, and damage


def announcing(path, count):
    """The AVI file with another number of frames in its headers."""
    data = bytearray(path.read_bytes())
    for place in (data.index(b"avih") + 8 + 16, data.index(b"strh") + 8 + 32):
        data[place : place + 4] = struct.pack("<I", count)
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("count", [33, 60])
def test_an_avi_that_ends_before_its_announced_count_is_refused(tmp_path, count):
    path = write_video(tmp_path / "clip.avi", noise(30, (32, 32)), "mpeg4", "yuv420p")
    assert len(list(open_clip(path))) == 30
    with pytest.raises(ValueError, match=r"clip\.avi is damaged or truncated: it announces .* --until-damage"):
        list(open_clip(announcing(path, count)))


@pytest.mark.parametrize("suffix", [".mp4", ".mkv"])
def test_a_damage_in_the_middle_ends_the_clip_only_where_that_is_asked_for(tmp_path, suffix):
    path = write_video(tmp_path / f"clip{suffix}", noise(60, (48, 64)), "libx264", "yuv420p")
    whole = [frame.grey for frame in open_clip(path)]
    data = bytearray(path.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 3000] = bytes(3000)
    path.write_bytes(data)
    with pytest.raises(ValueError, match=r"damaged or truncated: .*; to use the frames before that: --until-damage"):
        list(open_clip(path))
    with pytest.warns(ClipWarning, match="damaged or truncated: .*; the frames before that are used"):
        kept = [frame.grey for frame in open_clip(path, until_damage=True)]
    assert 10 < len(kept) < 60
    np.testing.assert_array_equal(kept[:10], whole[:10])


def test_a_truncated_file_is_used_up_to_its_end_where_that_is_asked_for(tmp_path):
    path = damaged(write_video(tmp_path / "clip.mkv", noise(60, (48, 64)), "libx264", "yuv420p"))
    with pytest.warns(ClipWarning, match="the frames before that are used"):
        assert 10 < len(list(open_clip(path, until_damage=True))) < 60
