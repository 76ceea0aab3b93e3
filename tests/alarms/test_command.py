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
from lgmd2jax._compute.finished_work import FileMemory
from lgmd2jax._figures.alarms import clips_figure
from lgmd2jax.alarms import Rendering, detectors, evaluate, load_labels
from lgmd2jax.alarms._starts import AlarmStarts
from lgmd2jax.cli import main
from tests.documents import CLIPS_EYE, SIX_CLIPS
from tests.videos import loom, noise, write_video

OWN = """
[[clip]]
file = "own.mkv"
[[clip]]
file = "hit.mkv"
alarm = [[18, 27]]
contact = 31
source = "garden"
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
    (place / "clips.toml").write_text(SIX_CLIPS)
    (place / "mine.toml").write_text(RECIPE)
    write_video(place / "own.mkv", list(noise(30)))
    write_video(place / "hit.mkv", list(loom(30, 40, 28)))
    (place / "own.toml").write_text(CLIPS_EYE + OWN)
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
    assert report.startswith("Fitted clips")
    assert "Held-out clips: 2 windows" in report
    assert "Table I, T_sp 0.65" in report


def test_own_clips_are_judged_by_what_was_fitted_without_their_source(place):
    content = json.loads((place / "mine/fit.json").read_text())
    assert set(content["left_out"]) == {"own", "hit"}  # no rendered one
    assert content["recipe"]["weights"]["recorded"] == 1
    comparison = content["comparisons"]["Recorded clips, each source judged by a fit without it"]
    assert comparison["thresholds_from"].endswith("of the fitted clips and the other sources")
    assert [clip["source"] for clip in comparison["clips"]] == ["own", "garden"]
    wrong, model = content["left_out"], comparison["detectors"]["model"]
    missed, broken = 1 - model["hits"]["count"], [clip["false_alarms"] > 0 for clip in comparison["clips"]]
    assert [wrong["own"], wrong["hit"]] == [broken[0], missed + broken[1]]
    report = (place / "mine/report.txt").read_text()
    assert "Recorded clips, each source judged by a fit without it" in report
    for name in ("frame difference", "divergence of flow", "Table I, T_sp 0.78"):
        assert report.count(name) >= 2 * 3


def test_the_paper_is_scored_with_its_own_structure(place):
    """Eq. 17 of Table I looks back by 4 frames and asks for 6 spikes, whatever the recipe's model does."""
    recipe = lgmd.alarms.load_recipe(place / "mine.toml")
    clips = tuple(Rendering(2, seed=2).clips(recipe.file.eye))
    judged = detectors(clips, dataclasses.replace(recipe.model, N_ts=6), flow=False)
    assert list(judged) == ["table1_T_sp_0.78", "table1_T_sp_0.65", "difference"]
    assert [judged[name].T_sp for name in list(judged)[:2]] == [0.78, 0.65]
    on = 0
    for clip, trace in zip(clips, judged["table1_T_sp_0.65"].evidence, strict=True):
        paper = lgmd.LGMD2(lgmd.preset("lgmd2", T_sp=0.65), eye=recipe.file.eye)
        collision = np.asarray(paper(clip.frames.astype(np.float32)).collision)
        np.testing.assert_array_equal(trace >= 0.65, collision > 0)
        on += collision.sum()
    assert on > 0


def test_the_handed_over_model_alarms_as_the_report_says(place):
    eye = lgmd.load(place / "mine/model.json").eye
    assert eye is not None
    with open(place / "mine/clips.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [rows.pop()["clip"] for _ in range(2)] == ["hit", "own"]
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
        (RECIPE.replace("seed = 9", "seed = 2"), "validation.seed = 2: the fitted clips have this seed too"),
        (RECIPE.replace("[solver]", "[solver]\nloss = 'huber'"), "solver.loss = 'huber': unknown key"),
        (RECIPE.replace("clips.toml", "looming"), "it is a protocol of stimuli, not a file of labelled clips"),
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


def test_what_is_stopped_amid_its_held_out_scores_goes_on_with_them(place, monkeypatch):
    """Whoever judges a detector again, of those that were judged before Ctrl-C, fails the test."""
    folder, write, keys = place / "amid", FileMemory.__setitem__, []
    (place / "urgent.toml").write_text(RECIPE + "[urgency]\nwithin_ms = 500\n")
    command = ["fit", str(place / "urgent.toml"), "--clips", str(place / "own.toml"), "-o", str(folder)]

    def stopped(self, key, value):
        write(self, key, value)
        keys.append(key)
        if key == "detectors, recorded clips":
            raise KeyboardInterrupt

    def stopped_again(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(FileMemory, "__setitem__", stopped)
        with pytest.raises(SystemExit, match="130"):
            main(command)
    assert {"the model, held out", "detectors, held out", "detectors, fitted clips"} < set(keys)
    left = ["the scores on held-out clips", "the urgency"]
    assert json.loads((folder / "fit.json").read_text())["unfinished"] == left
    with monkeypatch.context() as patch:
        for judge in ("evaluate", "detectors"):
            patch.setattr(f"lgmd2jax.cli.fit_alarms.{judge}", lambda *_, **__: pytest.fail("judged again"))
        patch.setattr("lgmd2jax.cli.fit_alarms.add_urgency", stopped_again)
        with pytest.raises(SystemExit, match="130"):
            main([*command, "--resume"])
        assert json.loads((folder / "fit.json").read_text())["unfinished"] == ["the urgency"]
        patch.setattr("lgmd2jax.cli.fit_alarms.add_urgency", lambda *_: "urgency: told")
        assert main([*command, "--resume"]) == 0
    for name in ("clips.csv", "report.txt"):
        assert (folder / name).read_bytes() == (place / "mine" / name).read_bytes()
    contents = [json.loads((at / "fit.json").read_text()) for at in (folder, place / "mine")]
    assert [content.pop(name) for content in contents for name in ("made", "name", "recipe", "digest")]
    assert contents[0] == contents[1]
    assert not list(place.glob(".*"))


def test_clips_go_with_alarms_alone(place, capsys):
    assert main(["fit", "twin", "--clips", str(place / "clips.toml")]) != 0
    assert "--clips is for a recipe of kind 'alarms'" in capsys.readouterr().err


def test_a_protocol_of_labelled_clips_is_no_protocol_of_stimuli(capsys):
    with pytest.raises(ValueError, match="it is a file of labelled clips, not a protocol of stimuli"):
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
        assert list(csv.reader(judged)) == list(csv.reader(fitted))[:-2]  # the last are the own clips
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


def test_watching_beside_plain_detectors(place, capsys):
    outputs = {name: place / f"beside.{name}" for name in ("json", "png", "csv")}
    command = ["watch", str(place / "clips.toml"), "--model", str(place / "mine/model.json"), "--baselines"]
    options = {"--json": "json", "--figure": "png", "--csv": "csv"}
    assert not main([*command, *(word for option, name in options.items() for word in (option, str(outputs[name])))])
    said = capsys.readouterr().out
    content = json.loads(outputs["json"].read_text())
    assert list(content["detectors"]) == ["model", "table1_T_sp_0.78", "table1_T_sp_0.65", "difference", "divergence"]
    assert content["thresholds_from"] in " ".join(said.split())
    with open(outputs["csv"], newline="") as file:
        rows = list(csv.DictReader(file))
    model = content["detectors"]["model"]
    assert sum(int(row["hits"]) for row in rows) == model["hits"]["count"]
    assert sum(int(row["false_alarms"]) for row in rows) == model["false_alarms_per_minute"]["count"]
    assert {float(row["fps"]) for row in rows} >= {30.0}
    for colour in ("#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7"):
        pixels = iio.imread(outputs["png"])[..., :3]
        assert (np.abs(pixels - 255 * np.array(to_rgb(colour))) < 2).all(axis=-1).any()


def test_own_clips_alone(place, monkeypatch):
    """Nothing is rendered, and the labels of one's own clips alone are fitted."""

    def stop(recipe, clips, **settings):
        assert [clip.name for clip in clips] == ["own", "hit"]
        raise KeyboardInterrupt

    monkeypatch.setattr("lgmd2jax.alarms._decoding.cache_folder", lambda: place / "lgmd2jax")
    monkeypatch.setattr(lgmd.alarms.AlarmRecipe, "run", stop)
    monkeypatch.setattr(Rendering, "clips", lambda *_: pytest.fail("rendered"))
    command = ["fit", str(place / "mine.toml"), "--clips", str(place / "own.toml"), "--clips-only"]
    assert main([*command, "-o", str(place / "alone")]) == 130


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--clips-only"], "--clips-only is given without clips of your own"),
        (["--clips-weight", "2"], "--clips-weight is given without clips of your own"),
        (["--clips", "own.toml", "--clips-only", "--clips-weight", "2"], "leaves no other clips to weigh against"),
        (["--clips", "own.toml", "--clips-weight", "-1"], "--clips-weight is -1; give a positive number"),
    ],
)
def test_options_that_say_nothing(place, options, message, capsys):
    assert main(["fit", str(place / "mine.toml"), *options]) == 1
    assert message in capsys.readouterr().err


def test_wrong_labels_show_before_anything_is_rendered(place, monkeypatch, capsys):
    wrong = (place / "own.toml").read_text().replace("[18, 27]", "[27, 18]")
    (place / "wrong.toml").write_text(wrong)
    monkeypatch.setattr(Rendering, "clips", lambda *_: pytest.fail("rendered"))
    monkeypatch.setattr("lgmd2jax._video.clip.Clip.record", lambda *_: pytest.fail("decoded"))
    assert main(["fit", str(place / "mine.toml"), "--clips", str(place / "wrong.toml")]) == 1
    assert "hit: alarm 27 to 18 is reversed" in capsys.readouterr().err


def test_watching_takes_an_lgmd2_and_labels(place, capsys):
    assert main(["watch", str(place / "clips.toml"), "--model", "preset:yue_rind"]) != 0
    assert "is not an LGMD2" in capsys.readouterr().err
    assert main(["watch", str(place / "mine.toml")]) != 0
    assert "it is a recipe, not a file of labelled clips" in capsys.readouterr().err
