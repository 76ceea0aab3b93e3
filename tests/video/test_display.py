"""A stimulus as a video for a display: what is in the file is what the display is to show."""

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax._video.display import display_frames, luminance_of

av = pytest.importorskip("av")
EYE = lgmd.Eye(rows=24, cols=32, degrees_per_pixel=3.0, fps=60.0)


@pytest.fixture(scope="module")
def stimulus():
    return lgmd.stimuli.looming(EYE, l_over_v=20.0, contrast=-0.9, start_ms=-200, end_ms=100)


def pictures(path):
    with av.open(str(path)) as container:
        return np.stack([frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)])


def test_the_file_holds_every_value_and_the_patch(stimulus, tmp_path):
    lgmd.save_display_video(stimulus, tmp_path / "loom.mkv", gamma=2.2, scale=2)
    found = pictures(tmp_path / "loom.mkv")
    expected = display_frames(stimulus, gamma=2.2)
    assert found.shape == (len(stimulus.time), 48, 64, 3)
    np.testing.assert_array_equal(found[..., 0], found[..., 2])
    np.testing.assert_array_equal(found[:, ::2, 4::2, 0], expected[:, :, 2:])
    np.testing.assert_array_equal(found[:, -1, 0, 0], 255 * (np.arange(len(found)) % 2 == 0))
    assert (tmp_path / "loom.mkv").stat().st_size > 0


def test_the_display_gives_the_luminance_back(stimulus):
    levels = luminance_of(display_frames(stimulus, gamma=2.2), 2.2)
    np.testing.assert_allclose(
        levels, stimulus.frames, atol=0.5 * 2.2
    )  # half a level of the display, where it is steepest
    np.testing.assert_array_equal(display_frames(stimulus, gamma=1), np.rint(stimulus.frames))


def test_another_frame_rate_holds_the_last_frame(stimulus):
    shown = display_frames(stimulus, fps=120, gamma=1)
    assert len(shown) == 2 * len(stimulus.time) - 1
    np.testing.assert_array_equal(shown[::2], np.rint(stimulus.frames))
    np.testing.assert_array_equal(shown[1::2], shown[:-1:2])


def test_misuse_is_refused(stimulus, tmp_path):
    with pytest.raises(ValueError, match=r"end its name in \.mkv or \.mp4"):
        lgmd.save_display_video(stimulus, tmp_path / "loom.gif")
    with pytest.raises(ValueError, match="gamma is 0; give a positive number"):
        lgmd.save_display_video(stimulus, tmp_path / "loom.mkv", gamma=0)
