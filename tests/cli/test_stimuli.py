"""`lgmd2jax stimuli`: a sheet and clips that are whole, repeatable and what was rendered, or nothing."""

import imageio.v3 as iio
import jax.numpy as jnp
import numpy as np
import pytest

from lgmd2jax import Eye, load_protocol
from lgmd2jax._figures import stimuli as _figures_stimuli
from lgmd2jax._figures.contact_sheet import Card
from lgmd2jax.alarms import Rendering
from lgmd2jax.cli import main
from lgmd2jax.stimuli import Stimulus

PROTOCOL = """
[eye]
rows = 13
cols = 17
degrees_per_pixel = 5
fps = 40

[[condition]]
name = "dark/light loom {contrast}"
family = "looming"
contrast = [-0.9, 0.2]
start_ms = -400
end_ms = 0
"""


@pytest.fixture
def protocol(tmp_path):
    path = tmp_path / "trial.toml"
    path.write_text(PROTOCOL)
    return path


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_the_sheet_goes_beside_the_protocol(protocol, capsys):
    assert main(["stimuli", str(protocol)]) == 0
    assert capsys.readouterr().out == f"wrote {protocol.with_suffix('.png')}\n"
    assert names(protocol.parent) == ["trial.png", "trial.toml"]
    sheet = iio.imread(protocol.with_suffix(".png"))
    assert sheet.shape[1] > 2 * sheet.shape[0]  # two cards side by side


def test_a_shipped_protocol_is_drawn_here(tmp_path, monkeypatch, protocol):
    monkeypatch.setattr("lgmd2jax._files.catalogue.folder", lambda kind: tmp_path)
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert main(["stimuli", "trial"]) == 0
    assert names(tmp_path / "here") == ["trial.png"]


def test_long_protocols_have_pages(protocol, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(_figures_stimuli, "PAGE", 1)
    assert main(["stimuli", str(protocol), "-o", str(tmp_path / "new")]) == 0
    assert names(tmp_path / "new") == ["trial-1.png", "trial-2.png"]
    assert capsys.readouterr().out.count("wrote") == 2


def test_the_same_protocol_gives_the_same_file(protocol):
    sheets = []
    for _ in range(2):
        assert main(["stimuli", str(protocol)]) == 0
        sheets.append(protocol.with_suffix(".png").read_bytes())
    assert sheets[0] == sheets[1]


def test_labelled_clips_are_drawn_over_their_labels(protocol, monkeypatch):
    seen = []
    monkeypatch.setattr(_figures_stimuli, "contact_sheet", lambda path, cards, title: seen.append((title, cards)))
    eye = PROTOCOL.split("[[condition]]")[0]
    protocol.write_text(f"{eye}[rendered]\ncount = 400\nseed = 1\n")
    monkeypatch.setattr("lgmd2jax.cli.stimuli._RENDERED", 3)
    assert main(["stimuli", str(protocol), "--clips", "npz"]) == 0
    ((title, cards),) = seen
    assert title == "trial: 3 labelled clips"
    clips = Rendering(3, seed=1).clips(Eye(13, 17, 5.0, 40.0))
    assert {it.name for it in cards} == {it.name for it in clips}
    assert [it.name[4:] for it in cards] == sorted(it.name[4:] for it in cards)
    for card in cards:
        assert card.label == "alarm\n(wanted)"
        known = card.course[np.isfinite(card.course)]
        assert set(known) == ({0, 1} if "collision" in card.name else {0})
        assert np.isnan(card.course[:10]).all()  # what is not judged
    assert len(names(protocol.parent / "trial-clips")) == 3


@pytest.mark.parametrize("form", ["npz", "png", "mp4"])
def test_clips_are_the_frames_at_their_rate(protocol, form, capsys):
    assert main(["stimuli", str(protocol), "--clips", form]) == 0
    folder = protocol.parent / "trial-clips"
    assert f"wrote {folder} (2 clips)" in capsys.readouterr().out
    suffix = "" if form == "png" else f".{form}"
    assert names(folder) == [f"001-dark-light-loom--0.9{suffix}", f"002-dark-light-loom-0.2{suffix}"]
    stimulus = load_protocol(protocol).conditions[0].render()
    frames = np.round(np.asarray(stimulus.frames))
    clip = folder / names(folder)[0]
    if form == "npz":
        arrays = np.load(clip)
        np.testing.assert_array_equal(arrays["frames"], frames)
        np.testing.assert_allclose(arrays["time_ms"], stimulus.time)
        assert arrays["frames"].dtype == np.uint8
        assert (arrays["fps"], arrays["name"]) == (40, "dark/light loom -0.9")
    elif form == "png":
        np.testing.assert_array_equal([iio.imread(picture) for picture in sorted(clip.iterdir())], frames)
    else:
        film = iio.imread(clip, plugin="pyav")[:, :13, :17].mean(axis=-1)
        assert iio.immeta(clip, plugin="pyav")["fps"] == 40
        assert film.shape == frames.shape
        assert np.abs(film - frames).mean() < 4


def test_clips_of_an_earlier_run_are_replaced_and_nothing_else_is(protocol, capsys):
    folder = protocol.parent / "trial-clips"
    assert main(["stimuli", str(protocol), "--clips", "npz"]) == 0
    assert main(["stimuli", str(protocol), "--clips", "png"]) == 0
    assert all(path.is_dir() for path in folder.iterdir())
    (folder / "notes.txt").touch()
    before = names(folder)
    capsys.readouterr()
    assert main(["stimuli", str(protocol), "--clips", "npz"]) == 1
    assert "holds more than clips" in capsys.readouterr().err
    assert names(folder) == before
    assert names(protocol.parent) == ["trial-clips", "trial.png", "trial.toml"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("0.2]", "3.0]"), "condition 'dark/light loom 3': contrast is 3"),
        (("looming", "zooming"), "condition[0].family = 'zooming': choose 'looming'"),
        (("[eye]", "[eye"), "not a TOML file"),
    ],
)
def test_a_mistake_is_one_line_and_leaves_nothing(protocol, tmp_path, untyped, capsys, change, message):
    protocol.write_text(PROTOCOL.replace(*change))
    (tmp_path / "new").mkdir()
    assert main(["stimuli", str(protocol), "--clips", "npz", "-o", str(tmp_path / "new")]) == 1
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.err.startswith(f"lgmd2jax: {protocol}")
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert names(tmp_path / "new") == []


def test_a_card_shows_the_frames_in_which_something_happens():
    frames = np.full((100, 8, 24), 100.0) + np.random.default_rng(0).normal(0, 2, (100, 8, 24))
    for i in range(60, 84):
        frames[i:, :, i - 60] = 0.0  # one column a frame turns black
    courses = {"radius_px": jnp.zeros(100), "full_angle_deg": jnp.arange(100.0)}
    card = Card.of(Stimulus(jnp.asarray(frames), 50.0, jnp.arange(100.0), "black comes", courses=courses), count=5)
    assert (card.name, card.label) == ("black comes", "full angle\n(deg)")
    np.testing.assert_array_equal(card.course, courses["full_angle_deg"])
    np.testing.assert_array_equal(card.frames, frames[card.shown])
    assert (card.shown[0], card.shown[-1]) == (0, 99)
    assert np.all((card.shown[1:-1] >= 60) & (card.shown[1:-1] < 84))
    assert len(set(card.shown)) == 5


def test_a_card_of_a_steady_motion_spaces_its_frames_by_time():
    frames = jnp.broadcast_to(100 * (jnp.arange(41.0) % 2)[:, None, None], (41, 4, 4))
    stimulus = Stimulus(frames, 50.0, jnp.arange(41.0), "flicker", courses={"level": frames[:, 0, 0]})
    np.testing.assert_array_equal(Card.of(stimulus, count=5).shown, [0, 10, 20, 30, 40])
