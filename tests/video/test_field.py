"""A film of another shape than the eye's gets a word, and a crop by which it has the eye's."""

import re

import pytest

import lgmd2jax as lgmd
from lgmd2jax._video.clip import open_clip, window_of
from lgmd2jax._video.field import field_remark
from lgmd2jax._video.remarks import ClipWarning
from lgmd2jax.alarms import load_labels
from lgmd2jax.cli import main
from tests.videos import noise, write_video

EYE = lgmd.Eye(20, 36, degrees_per_pixel=1.95, fps=30.0)
LABELS = '[eye]\nrows = 20\ncols = 36\ndegrees_per_pixel = 1.95\nfps = 30\n[[clip]]\nfile = "a.mkv"\n'


def remark_on(clip):
    return field_remark(clip.size, clip.window, clip.shape, EYE)


@pytest.mark.parametrize("size", [(96, 54), (54, 54), (24, 96)])
@pytest.mark.parametrize("within", [None, "4:,3:"])
def test_the_crop_of_the_remark_gives_the_shape_of_the_eye(tmp_path, size, within):
    path = write_video(tmp_path / "a.mkv", list(noise(2, size)))
    used = None if within is None else window_of(within)
    clip = open_clip(path, resize=36, crop=used)
    remark = remark_on(clip)
    assert remark is not None
    assert f"the model sees {clip.shape[0]} x 36 pixels, but the eye has 20 x 36" in remark
    (crop,) = re.findall(r'crop = "(\S+)" \(--crop \1\)', remark)
    mended = open_clip(path, resize=36, crop=window_of(crop))
    assert abs(mended.shape[0] - 20) <= 1
    assert remark_on(mended) is None
    for part, whole, edge in zip(mended.window, clip.window, size, strict=True):
        (first, end, _), (low, high, _) = part.indices(edge), whole.indices(edge)
        assert low <= first < end <= high
        assert abs((first - low) - (high - end)) <= 1


@pytest.mark.parametrize("size", [(54, 96), (48, 64)])
def test_the_usual_formats_get_no_remark(tmp_path, size):
    assert remark_on(open_clip(write_video(tmp_path / "a.mkv", list(noise(2, size))), resize=36)) is None


def test_respond_and_watch_say_so_once(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("a", "b"):
        write_video(tmp_path / f"{name}.mkv", list(noise(30, (96, 54))))
    lgmd.save(lgmd.LGMD2(eye=EYE), "model.json")
    assert main(["respond", "a.mkv", "--model", "model.json"]) == 0
    said = "the model sees 64 x 36 pixels, but the eye has 20 x 36, and an object fills another share of such a field"
    assert capsys.readouterr().err.startswith(f'lgmd2jax: warning: {said}; crop = "33:63,0:54"')
    (tmp_path / "mine.toml").write_text(LABELS + '[[clip]]\nfile = "b.mkv"\n')
    assert main(["watch", "mine.toml", "--model", "model.json"]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f'lgmd2jax: warning: a, b: {said}; crop = "33:63,0:54"')
    with pytest.warns(ClipWarning, match="a, b: the model sees 64 x 36"):
        load_labels("mine.toml").load()
    (tmp_path / "tall.toml").write_text(LABELS.replace("rows = 20", "rows = 64"))
    assert main(["watch", "tall.toml", "--model", "model.json"]) == 0
    said = "the model's eye has 20 x 36 pixels, but that of tall.toml has 64 x 36"
    assert capsys.readouterr().err.startswith(f"lgmd2jax: warning: {said}; an object")
