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
