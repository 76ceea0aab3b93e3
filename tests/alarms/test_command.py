"""`lgmd2jax fit` with a recipe of kind "alarms", from labelled clips to a folder."""

import csv
import dataclasses
import json

import imageio.v3 as iio
import numpy as np
import pytest
from matplotlib.colors import to_rgb

import lgmd2jax as lgmd
from lgmd2jax import hard
from lgmd2jax._figures.alarms import clips_figure
from lgmd2jax.alarms import Rendering, evaluate, load_labels
from lgmd2jax.alarms._starts import AlarmStarts
from lgmd2jax.cli import main
from lgmd2jax.cli.fit_alarms import _held_out_scores
from tests.videos import noise, write_video

PROTOCOL = """
[eye]
rows = 12
cols = 18
degrees_per_pixel = 4
fps = 30
projection = "pinhole"
[rendered]
count = 6
seed = 2
"""
RECIPE = """
protocol = "clips.toml"
kind = "alarms"
[parameters]
N_sp = 4
[free]
k = { low = 0.1, high = 2 }
T_ffi = { low = 2, high = 60 }
[weights]
miss = 1
false_alarm = 2.5
[solver]
pixel_points = 1
cell_points = 64
generations = 1
descend = 0
[validation]
count = 4
seed = 9
"""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with a recipe, a clip of one's own beside the rendered ones, and the results of both."""
    place = tmp_path_factory.mktemp("alarms")
    (place / "clips.toml").write_text(PROTOCOL)
    (place / "mine.toml").write_text(RECIPE)
    write_video(place / "own.mkv", list(noise(30)))
    (place / "own.toml").write_text(PROTOCOL.split("[rendered]")[0] + '[[clip]]\nfile = "own.mkv"\n')
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lgmd2jax.alarms._decoding.cache_folder", lambda: place / "lgmd2jax")
        assert not main(["fit", str(place / "mine.toml"), "--clips", str(place / "own.toml")])
    return place


def test_the_folder(place):
    names = {path.name for path in (place / "mine").iterdir()}
    assert names == {
        "model.json",
        "fit.json",
        "clips.csv",
        "fit.png",
        "diagnostics.png",
        "worst.png",
        "report.txt",
        "report.html",
    }
    assert not list(place.glob(".*"))
    content = json.loads((place / "mine/fit.json").read_text())
    assert content["screened"] == 64
    assert set(content["values"]) == {"k", "T_ffi", "T_sp"}
    assert content["held_out"]["windows"] == 2
    report = (place / "mine/report.txt").read_text()
    assert "Clips that the fit did not see: 2 windows" in report
    assert "Table I, T_sp 0.65" in report


def test_the_paper_is_scored_with_its_own_structure(place, monkeypatch):
    """Eq. 17 of Table I looks back by 4 frames, whatever the recipe's model does."""
    judged = []
    monkeypatch.setattr(
        "lgmd2jax.cli.fit_alarms.evaluate", lambda model, clips: judged.append(model) or evaluate(model, clips)
    )
    recipe = lgmd.alarms.load_recipe(place / "mine.toml")
    fitted = dataclasses.replace(recipe.model, N_ts=6)
    scores = _held_out_scores(recipe, fitted)
    assert list(scores.scores) == ["fitted", "Table I, T_sp 0.78", "Table I, T_sp 0.65"]
    assert [model.N_ts for model in judged] == [6, 4, 4]
    assert [float(model.parameters.T_sp) for model in judged[1:]] == pytest.approx([0.78, 0.65])
    assert [float(model.parameters.N_sp) for model in judged[1:]] == [lgmd.preset("lgmd2").N_sp] * 2


def test_the_handed_over_model_alarms_as_the_report_says(place):
    eye = lgmd.load(place / "mine/model.json").eye
    assert eye is not None
    with open(place / "mine/clips.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert rows.pop()["clip"] == "own"
    for clip, row in zip(Rendering(6, seed=2).clips(eye), rows, strict=True):
        robot = hard.load(place / "mine/model.json")
        on = [bool(robot.step(frame).collision) for frame in clip.frames.astype(float)]
        expected = np.zeros(len(on), bool)
        for stretch in row["alarms"].split():
            first, last = map(int, stretch.split("-"))
            expected[first : last + 1] = True
        np.testing.assert_array_equal(on, expected)
        assert row["clip"] == clip.name


@pytest.mark.parametrize(
    ("recipe", "message"),
    [
        (RECIPE.replace("seed = 9", "seed = 2"), "validation.seed = 2: is that of the clips that are fitted"),
        (RECIPE.replace("[solver]", "[solver]\nloss = 'huber'"), "solver.loss = 'huber': unknown key"),
        (RECIPE.replace("clips.toml", "looming"), "condition = [{"),
        (RECIPE.replace("k = {", "kk = {"), "free.kk = {"),
    ],
)
def test_a_recipe_that_is_none_says_why_in_one_line(place, recipe, message, capsys):
    (place / "bad.toml").write_text(recipe)
    assert main(["fit", str(place / "bad.toml")]) != 0
    said = capsys.readouterr().err.strip()
    assert message in said
    assert "\n" not in said
    assert not (place / "bad").exists()


def test_ctrl_c_before_anything_is_finished_writes_nothing(place, monkeypatch, capsys):
    def pressed(self):
        raise KeyboardInterrupt

    monkeypatch.setattr(AlarmStarts, "compile_screening", pressed)
    assert main(["fit", str(place / "mine.toml"), "-o", str(place / "stopped")]) == 130
    assert capsys.readouterr().err.strip().endswith("stopped; nothing was written")
    assert not (place / "stopped").exists()


def test_clips_go_with_alarms_alone(place, capsys):
    assert main(["fit", "twin", "--clips", str(place / "clips.toml")]) != 0
    assert "--clips is for a recipe of kind 'alarms'" in capsys.readouterr().err


def test_a_protocol_of_labelled_clips_is_no_protocol_of_stimuli(capsys):
    with pytest.raises(ValueError, match="holds labelled clips, for recipes of kind 'alarms'"):
        lgmd.load_protocol("video")


def bars(path, colour, alpha):
    """How many lines of a figure have a bar of this colour, longer than the legend's."""
    pixels = iio.imread(path)[..., :3]
    expected = 255 * (1 - alpha * (1 - np.array(to_rgb(colour))))
    lines = np.all(np.abs(pixels - expected) < 2, axis=-1).sum(axis=1) > 60
    return np.sum(np.diff(lines.astype(int)) == 1)


def test_a_model_is_judged_on_clips_without_a_fit(place, capsys):
    table, figure, model = place / "judged.csv", place / "judged.png", str(place / "mine/model.json")
    command = ["watch", str(place / "clips.toml"), "--model", model]
    assert not main([*command, "--csv", str(table), "--figure", str(figure)])
    with open(table, newline="") as judged, open(place / "mine/clips.csv", newline="") as fitted:
        assert list(csv.reader(judged)) == list(csv.reader(fitted))[:-1]  # the last is the own clip
    assert "clip" in capsys.readouterr().out
    handed_over = lgmd.load(model)
    assert isinstance(handed_over, lgmd.LGMD2)
    evaluation = evaluate(handed_over, load_labels(place / "clips.toml").load())
    clips_figure(place / "expected.png", evaluation, model)
    np.testing.assert_array_equal(iio.imread(figure), iio.imread(place / "expected.png"))
    clips_figure(place / "never.png", dataclasses.replace(evaluation, T_sp=1.0), model)
    assert (iio.imread(figure) != iio.imread(place / "never.png")).any()


def test_a_model_and_clips_of_another_scale(place, capsys):
    """A fit refuses to mix them, since one parameter set cannot be right for both; watching says so and goes on."""
    coarse = (place / "own.toml").read_text().replace("degrees_per_pixel = ", "degrees_per_pixel = 1")
    (place / "coarse.toml").write_text(coarse)
    assert main(["fit", str(place / "mine.toml"), "--clips", str(place / "coarse.toml"), "-o", str(place / "mix")]) != 0
    assert "coarse.toml has degrees_per_pixel = 1" in capsys.readouterr().err
    assert not (place / "mix").exists()
    model = ["--model", str(place / "mine/model.json")]
    assert not main(["watch", str(place / "own.toml"), *model])
    assert "warning" not in capsys.readouterr().err
    assert not main(["watch", str(place / "coarse.toml"), *model])
    assert "warning: the model has degrees_per_pixel = " in capsys.readouterr().err


def test_watching_takes_an_lgmd2_and_labels(place, capsys):
    assert main(["watch", str(place / "clips.toml"), "--model", "preset:yue_rind"]) != 0
    assert "is no LGMD2" in capsys.readouterr().err
    assert main(["watch", str(place / "mine.toml")]) != 0
    assert "unknown key" in capsys.readouterr().err
