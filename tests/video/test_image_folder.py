"""A folder of images: which are frames, in which order, and what is said of gaps."""

import numpy as np
import pytest
from PIL import Image

from lgmd2jax._video.clip import open_clip
from lgmd2jax._video.remarks import ClipWarning
from tests.videos import noise, write_folder


def levels(folder):
    return [round(float(frame.grey.mean())) for frame in open_clip(folder, fps=30)]


def named(folder, names):
    """An image for each name, one grey level brighter than the one before."""
    for level, name in enumerate(names):
        Image.fromarray(np.full((4, 4), level, np.uint8)).save(folder / name)
    return folder


@pytest.mark.parametrize(
    "names",
    [
        ["8.png", "9.png", "10.png", "11.png"],
        ["a0000.png", "a0010.png", "a0020.png"],
        ["f-1.png", "f-2.png", "f-3.png"],
        ["2024-01-09_1.png", "2024-01-10_2.png"],
        ["a.png", "b.png", "c.png"],
    ],
)
def test_images_are_in_natural_order_and_nothing_need_be_said(tmp_path, names):
    assert levels(named(tmp_path, names)) == list(range(len(names)))


@pytest.mark.parametrize(
    "names", [["t-10.png", "t-2.png", "t0.png", "t3.png"], ["-3.png", "-2.png", "-1.png"], ["-1.png", "0.png", "1.png"]]
)
def test_numbers_below_zero_come_first_and_are_said(tmp_path, names):
    with pytest.warns(ClipWarning) as said:
        assert levels(named(tmp_path, names)) == list(range(len(names)))
    assert any("a hyphen before a number is a minus" in str(it.message) for it in said)


def test_a_gap_is_said(tmp_path):
    with pytest.warns(ClipWarning, match=r"not evenly spaced, first between 3\.png and 5\.png"):
        levels(named(tmp_path, ["1.png", "2.png", "3.png", "5.png", "6.png"]))


def test_hidden_and_empty_files_do_not_stop_a_folder(tmp_path):
    folder = write_folder(tmp_path / "frames", noise(4))
    (folder / "._0.png").write_bytes(b"\0\5\x16\7 no image")
    (folder / "4.png").touch()
    with pytest.warns(ClipWarning, match=r"1 images are empty \(0 bytes\), the first 4\.png; they are passed over"):
        clip = open_clip(folder, fps=30)
    assert [frame.index for frame in clip] == [0, 1, 2, 3]
    for path in folder.glob("[0-9].png"):
        path.write_bytes(b"")
    with pytest.raises(ValueError, match="holds empty images alone"):
        open_clip(folder, fps=30)


@pytest.mark.parametrize("suffix", [".png", ".webp"])
def test_the_pictures_of_an_animation_are_frames(tmp_path, suffix):
    """As a folder among other images, and as a file of its own."""
    pictures = [Image.fromarray(np.full((8, 8), level, np.uint8)) for level in (10, 60, 110)]
    pictures[0].save(tmp_path / f"2{suffix}", save_all=True, append_images=pictures[1:], duration=40, lossless=True)
    pictures[2].save(tmp_path / "10.png")
    in_folder = open_clip(tmp_path, fps=25)
    assert in_folder.count is None
    assert [float(frame.grey.mean()) for frame in in_folder] == pytest.approx([10, 60, 110, 110], abs=1e-4)
    alone = list(open_clip(tmp_path / f"2{suffix}", fps=25))
    assert [float(frame.grey.mean()) for frame in alone] == pytest.approx([10, 60, 110], abs=1e-4)
    assert [frame.time for frame in alone] == [0, 40, 80]
