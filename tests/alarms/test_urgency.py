"""Urgency: calibrated where the truth is known, the same in both programs, kept in the hand-over file."""

import dataclasses
import json
import pathlib
import shutil

import numpy as np
import pytest
import scipy

import lgmd2jax as lgmd
from lgmd2jax import alarms, hard
from lgmd2jax._handover.model_file import as_hard
from lgmd2jax.alarms._reliability import calibration_table, logistic_fit
from lgmd2jax.alarms._urgency import _judged
from lgmd2jax.cli import main
from tests import clips
from tests.documents import SIX_CLIPS
from tests.network.test_mechanisms import PARAMETERS

ROOT = pathlib.Path(__file__).parents[2]
TRUE = np.array([-2.0, 3.0, -1.5, 2.0, 0.5])  # intercept and weights
URGENCY = alarms.Urgency(500.0, 150.0, -1.0, 4.0, 2.0, -3.0, 1.5)
TABLE = dataclasses.replace(URGENCY, predicted=(0.1, 0.3, 0.6), observed=(0.05, 0.3, 0.5))
INTERVALS = np.random.default_rng(2).uniform(15, 60, 14)


def simulated(seed, count=12_000):
    """Evidence, and whether contact follows, with a probability that is known."""
    generator = np.random.default_rng(seed)
    x = generator.uniform(0, 1, (count, 4)) * [0.5, 0.5, 0.4, 1.0]
    return x, generator.random(count) < scipy.special.expit(TRUE[0] + x @ TRUE[1:])


def test_on_known_probabilities_the_calibration_is_right():
    x, happens = simulated(0)
    intercept, *weights = logistic_fit(x, happens)
    design = np.column_stack([np.ones(len(x)), x])
    p = scipy.special.expit(design @ [intercept, *weights])
    # At the most likelihood no column has anything left to explain.
    np.testing.assert_allclose(design.T @ (p - happens) / len(x), 0, atol=1e-5)
    errors = np.sqrt(np.diag(np.linalg.inv((design.T * (p * (1 - p))) @ design)))
    assert np.all(np.abs(np.array([intercept, *weights]) - TRUE) < 3.5 * errors)

    held, came = simulated(1)
    clip = np.arange(len(held)) // 20
    predicted = scipy.special.expit(intercept + held @ weights)
    found = alarms.Reliability.of(predicted, came, clip)
    assert found.slope.low < 1 < found.slope.high
    assert found.intercept.low < 0 < found.intercept.high
    assert found.slope.high - found.slope.low < 0.25
    error = np.sqrt(found.predicted * (1 - found.predicted) / found.frames)
    assert np.all(np.abs([share.value for share in found.observed] - found.predicted) < 4 * error)
    inside = [share.low <= p <= share.high for share, p in zip(found.observed, found.predicted, strict=True)]
    assert np.mean(inside) >= 0.8
    assert found.frames.sum() == len(held)
    assert found.brier.value == pytest.approx(np.mean((predicted - came) ** 2))
    assert found.brier.low < np.mean(predicted * (1 - predicted)) < found.brier.high  # what the truth leaves
    assert found.brier.high < found.brier_of_the_mean == pytest.approx(np.var(came))


def test_a_calibration_on_other_clips_corrects_overconfidence():
    """Known probabilities, of which a logistic function says twice the log-odds."""
    x, happens = simulated(3)
    z = TRUE[0] + x @ TRUE[1:]
    predicted, observed = calibration_table(scipy.special.expit(2 * z), happens)
    assert np.all(np.diff(predicted) > 0)
    assert np.all(np.diff(observed) >= 0)
    truth = scipy.special.expit(scipy.special.logit(predicted) / 2)
    np.testing.assert_allclose(observed, truth, atol=0.06)
    held, came = simulated(5)
    said = np.interp(scipy.special.expit(2 * (TRUE[0] + held @ TRUE[1:])), predicted, observed)
    found = alarms.Reliability.of(said, came, np.arange(len(held)) // 20)
    assert found.slope.low < 1 < found.slope.high


def test_overconfidence_shows():
    x, happens = simulated(3)
    overconfident = scipy.special.expit(2 * (TRUE[0] + x @ TRUE[1:]))
    found = alarms.Reliability.of(overconfident, happens, np.arange(len(x)) // 20)
    assert found.slope.value == pytest.approx(0.5, abs=0.05)
    assert found.slope.high < 0.6


def test_frames_of_a_clip_that_go_together_widen_the_intervals():
    """Every frame ten times over is no more evidence than once."""
    x, happens = simulated(4, 1000)
    p, clip = scipy.special.expit(TRUE[0] + x @ TRUE[1:]), np.arange(1000)
    once = alarms.Reliability.of(p, happens, clip)
    tenfold = alarms.Reliability.of(*(np.repeat(each, 10) for each in (p, happens, clip)))
    for name in ("slope", "intercept", "brier"):
        assert getattr(tenfold, name) == pytest.approx(getattr(once, name), rel=1e-4, abs=1e-4)


@pytest.mark.parametrize("urgency", [URGENCY, TABLE], ids=["logistic", "table"])
@pytest.mark.parametrize("mechanisms", [(), ("size", "shunt", "lag")], ids=str)
def test_both_programs_tell_the_same(mechanisms, urgency):
    model = lgmd.LGMD2(PARAMETERS, mechanisms=mechanisms)
    frames = clips.patchy(33, (14, 5, 7))
    in_jax = np.asarray(urgency(model, model(frames, interval=INTERVALS), INTERVALS))
    whole = as_hard(model)
    program = hard.HardLGMD2(whole.parameters, mechanisms=mechanisms, urgency=dataclasses.asdict(urgency))
    in_numpy = hard.Response.over_time(map(program.step, frames, INTERVALS)).urgency
    np.testing.assert_allclose(in_numpy, in_jax, rtol=1e-10)
    assert np.ptp(in_jax) > 0.05
    program.reset()
    assert program.step(frames[0], INTERVALS[0]).urgency == pytest.approx(in_jax[0])
    assert np.isnan(whole.step(frames[0], 20.0).urgency)


def labelled(contact, windows=(), seed=0, count=40):
    return alarms.LabelledClip.of(
        f"clip {seed}", clips.noise(seed, (count, 4, 5)), 20.0, windows=windows, contact=contact
    )


def test_labels_of_frames():
    """50 ms a frame; 10 frames to settle; contact in frame 30, or 2 frames after the end; clips that do not tell."""
    shown = [labelled(30), labelled(41, seed=1), labelled(None, seed=2), labelled(None, [(20, 22)], 3)]
    _, happens, clip = _judged(lgmd.LGMD2(), shown, 250.0, 100.0)
    assert np.bincount(clip).tolist() == [20, 30, 30]
    assert np.flatnonzero(happens[clip == 0]).tolist() == [15, 16, 17, 18, 19]
    assert np.flatnonzero(happens[clip == 1]).tolist() == [26, 27, 28, 29]
    assert not happens[clip == 2].any()


def approaches():
    """Before contact a dark square grows; in the other clips nothing moves."""
    shown = []
    for seed in range(6):
        noise = clips.noise(seed, (40, 9, 9)) / 20 + 200
        for frame in range(25, 40):
            size = (frame - 22) // 4
            noise[frame, 4 - size : 5 + size, 4 - size : 5 + size] = 10 + frame % 2
        if seed % 2:
            noise = noise[:, :1].repeat(9, axis=1)[:1].repeat(40, axis=0)
        contact = None if seed % 2 else 40
        shown.append(alarms.LabelledClip.of(f"{seed}", noise, 20.0, contact=contact))
    return tuple(shown)


def test_a_fit_finds_what_tells_contact_and_says_how_well():
    shown = approaches()
    model = lgmd.LGMD2(lgmd.preset("lgmd2", T_ffi=100.0))
    urgency = alarms.fit_urgency(model, shown, within_ms=600)
    found = urgency.reliability(model, shown)
    assert found.brier.value < 0.4 * found.brier_of_the_mean
    response = model(shown[0].frames, interval=shown[0].interval)
    told = np.asarray(urgency(model, response, shown[0].interval))
    assert told[35:].mean() > 0.6 > 0.15 > told[10:25].mean()


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"within_ms": 0.0}, "within_ms is 0.0; give a positive number of ms"),
        ({"tau_ms": float("nan")}, "tau_ms is nan; give a positive number of ms"),
        ({"within_ms": 1.0}, "contact follows within 1 ms in none of the frames; give clips with contact"),
        ({"within_ms": 1e6}, "contact follows within 1e\\+06 ms in all of the frames"),
    ],
)
def test_a_fit_of_nothing_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        alarms.fit_urgency(lgmd.LGMD2(), [labelled(30)], **arguments)
    with pytest.raises(ValueError, match="no clip has a frame of contact"):
        alarms.fit_urgency(lgmd.LGMD2(), [labelled(None, [(20, 22)])])


# The hand-over file


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "model.json"
    shutil.copy(ROOT / "fits/twin/model.json", path)
    return path


def test_it_stands_in_the_file_and_all_else_stays(path):
    before = json.loads(path.read_text())
    assert alarms.load_urgency(path) is None
    frames = clips.noise(0, (6, 5, 7))
    assert np.isnan(hard.load(path)(frames).urgency).all()
    alarms.Urgency(400.0, 150.0, 0.0, 1.0, 2.0, 3.0, 4.0).save(path)
    URGENCY.save(path)
    after = json.loads(path.read_text())
    table = {name: value for name, value in dataclasses.asdict(URGENCY).items() if value != ()}
    assert after.pop("calibration") == {"urgency": table}
    assert after == before
    assert alarms.load_urgency(path) == URGENCY
    model = lgmd.load(path)
    for urgency in (TABLE, URGENCY):
        urgency.save(path)
        assert alarms.load_urgency(path) == urgency
        expected = urgency(model, model(frames), np.full(6, 1000 / model.eye.fps))
        np.testing.assert_allclose(hard.load(path)(frames).urgency, expected, rtol=1e-10)


def test_a_file_of_version_1_becomes_one_of_version_2(tmp_path):
    path = tmp_path / "model.json"
    shutil.copy(ROOT / "tests/golden/model_v1.json", path)
    before, frames = json.loads(path.read_text()), clips.noise(0, (6, 5, 7))
    expected = hard.load(path)(frames, 30.0)
    URGENCY.save(path)
    after = json.loads(path.read_text())
    assert (before["version"], after["version"], after["network"]) == (1, 2, "LGMD2")
    assert all(after[key] == before[key] for key in before if key != "version")
    found = hard.load(path)(frames, 30.0)
    np.testing.assert_array_equal(found.smp_adapted, expected.smp_adapted)
    assert np.isfinite(found.urgency).all()
    assert alarms.load_urgency(path) == URGENCY


@pytest.mark.parametrize("load", [hard.load, lgmd.load, alarms.load_urgency])
@pytest.mark.parametrize(
    "wrong",
    [
        {"level": None},
        {"tau_ms": 0},
        {"rise": "much"},
        {"within_ms": -5.0},
        {"colour": 1.0},
        {"observed": [0.1, 2.0], "predicted": [0.1, 0.2]},
        {"predicted": [0.1, "much"], "observed": [0.1, 0.2]},
    ],
    ids=str,
)
def test_a_wrong_one_is_refused_by_all_readers(load, wrong, path, tmp_path):
    content = json.loads(path.read_text())
    urgency = {**dataclasses.asdict(TABLE), **wrong}
    content["calibration"] = {"urgency": {name: value for name, value in urgency.items() if value is not None}}
    other = tmp_path / "model.json"
    other.write_text(json.dumps(content))
    with pytest.raises(ValueError, match=f"model.json is not a hand-over file that can be used: .*{next(iter(wrong))}"):
        load(other)


def test_what_is_no_number_never_reaches_the_file(path):
    before = path.read_bytes()
    with pytest.raises(ValueError, match="rise"):
        dataclasses.replace(URGENCY, rise=float("nan")).save(path)
    assert path.read_bytes() == before
    with pytest.raises(ValueError, match=r"urgency is .*; give within_ms, tau_ms"):
        hard.HardLGMD2(as_hard(lgmd.LGMD2()).parameters, urgency={"level": 1.0})


# The command


RECIPE = """
protocol = "clips.toml"
kind = "alarms"
[free]
k = {}
[validation]
count = 6
seed = 9
"""


def test_the_fit_does_not_see_it(tmp_path):
    """So that a recipe may ask for it later, and the work of its fit is still of that recipe."""
    (tmp_path / "clips.toml").write_text(SIX_CLIPS)
    digests = set()
    for number, addition in enumerate(("", "[urgency]\nwithin_ms = 400\n", "[weights]\nmiss = 2\n")):
        (tmp_path / f"{number}.toml").write_text(RECIPE + addition)
        digests.add(alarms.load_recipe(tmp_path / f"{number}.toml").digest(approaches()))
    assert len(digests) == 2


def test_the_shipped_fit_keeps_its_urgency_when_it_is_made_again():
    told = alarms.load_urgency(ROOT / "fits/video/model.json")
    assert told is not None
    assert alarms.load_recipe(ROOT / "fits/video.toml").within_ms == told.within_ms


def test_the_command_adds_it_to_a_folder(path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(alarms.LabelFile, "load", lambda *_: approaches())
    monkeypatch.setattr(alarms.AlarmRecipe, "held_out", lambda _: approaches())
    (tmp_path / "mine.toml").write_text(RECIPE)
    (tmp_path / "clips.toml").write_text(SIX_CLIPS)
    assert main(["calibrate", "mine.toml"]) == 1
    assert "mine holds no fit (there is no fit.json); make it first: lgmd2jax fit mine.toml" in capsys.readouterr().err
    folder = tmp_path / "mine"
    folder.mkdir()
    shutil.copy(path, folder)
    (folder / "fit.json").write_text('{"format": "lgmd2jax-fit"}')
    assert main(["calibrate", "mine.toml"]) == 1
    assert "mine holds a fit to curves; give the folder of one to labelled clips by -o" in capsys.readouterr().err
    (folder / "fit.json").write_text('{"format": "lgmd2jax-alarm-fit"}')
    (tmp_path / "clips.toml").write_text(SIX_CLIPS.replace("degrees_per_pixel = 4", "degrees_per_pixel = 2"))
    assert main(["calibrate", "mine.toml"]) == 1
    assert "has degrees_per_pixel = 4.0, but the recipe" in capsys.readouterr().err
    (tmp_path / "clips.toml").write_text(SIX_CLIPS)
    for given, words in (("nan", "--within-ms is nan; give a positive"), (".5", "within 0.5 ms is less than a frame")):
        assert main(["calibrate", "mine.toml", "--within-ms", given]) == 1
        assert words in capsys.readouterr().err
    assert main(["calibrate", "mine.toml", "--within-ms", "700"]) == 0
    said = capsys.readouterr().out
    assert "urgency: probability of contact within 700 ms, on" in said
    assert "Brier score 0." in said
    urgency = alarms.load_urgency(folder / "model.json")
    assert urgency is not None
    assert urgency.within_ms == 700
    numbers = json.loads((folder / "urgency.json").read_text())
    assert numbers["urgency"] == json.loads(json.dumps(dataclasses.asdict(urgency)))
    assert len(urgency.predicted) == len(urgency.observed) > 1
    assert 0 < numbers["held_out"]["brier"][0] < 1
    assert (folder / "reliability.png").stat().st_size > 10_000
    monkeypatch.setattr(alarms.AlarmRecipe, "run", lambda *_, **__: pytest.fail("no fit is wanted"))
    with pytest.raises(pytest.fail.Exception):
        main(["fit", "mine.toml"])
    assert "mine has an urgency, which this fit drops; keep one by [urgency] in the recipe" in capsys.readouterr().out
    (tmp_path / "mine.toml").write_text(RECIPE.split("[validation]")[0])
    assert main(["calibrate", "mine.toml"]) == 1
    assert "mine.toml has no [validation]" in capsys.readouterr().err
