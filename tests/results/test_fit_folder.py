"""A fit's folder: what is written comes back, and predicts the same."""

import csv
import dataclasses
import json
import shutil

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax._handover.named import model_named
from lgmd2jax._words import UnfinishedWarning
from tests.fitting.fits import curve, fit_with

FREE = lgmd.Free(theta2=None, tau1=None, gain=None, theta1=lgmd.Tie("theta2", 0.5))
FILES = ["curves.csv", "diagnostics.png", "fit.json", "fit.png", "model.json", "report.html", "report.txt"]


@pytest.fixture(scope="module")
def fit():
    rate = curve("recorded", "rate", sem=np.full(30, 2.0), seed=3)
    return fit_with(FREE, [curve(), curve(seed=1), rate], observation=lgmd.Observation(latency=33.0), z=[0.2, 1.0, 0.3])


@pytest.fixture(scope="module")
def folder(fit, tmp_path_factory):
    path = tmp_path_factory.mktemp("results") / "fit"
    lgmd.save_fit(fit, path, provenance={"recipe": "mine"}, notes={"digest": "abc"})
    return path


def test_the_folder_holds_all(folder):
    assert sorted(path.name for path in folder.iterdir()) == FILES
    assert json.loads((folder / "model.json").read_text())["provenance"]["recipe"] == "mine"
    assert json.loads((folder / "fit.json").read_text())["digest"] == "abc"


def test_what_was_written_comes_back(fit, folder):
    again = lgmd.load_fit(folder)
    assert again.summary() == fit.summary()
    assert again.values == fit.values
    assert again.free == fit.free
    assert again.runs == fit.runs
    assert again.observation.latency == 33
    np.testing.assert_array_equal(again.covariance, fit.covariance)
    np.testing.assert_array_equal(again.uncertainty.on_bound, fit.uncertainty.on_bound)
    assert again.uncertainty.determined.dtype == bool
    for one, two in zip(again.curves, fit.curves, strict=True):
        assert (one.condition, one.channel) == (two.condition, two.channel)
        np.testing.assert_allclose(one.hard, two.hard, rtol=1e-8)
        np.testing.assert_array_equal(np.isnan(one.sem), np.isnan(two.sem))
    stimulus = lgmd.stimuli.looming(
        lgmd.Eye(8, 10, 8.0, 60.0), l_over_v=20.0, contrast=-0.9, start_ms=-300.0, end_ms=100.0
    )
    np.testing.assert_array_equal(again.predict(stimulus), fit.predict(stimulus))
    with pytest.raises(ValueError, match="neither holds nor names its stimuli and targets; give them to load_fit"):
        again.profile("tau1")


def test_a_fit_that_was_stopped_is_marked_as_unfinished(tmp_path):
    lgmd.save_fit(fit_with(FREE, [curve()], result="stopped by hand"), tmp_path / "fit")
    assert "UNFINISHED" in (tmp_path / "fit/report.txt").read_text(encoding="utf-8")
    with pytest.warns(UnfinishedWarning, match="fit is unfinished: the search; lgmd2jax fit"):
        assert lgmd.load_fit(tmp_path / "fit").result == "stopped by hand"
    with pytest.warns(UnfinishedWarning, match="is of an unfinished fit: the search was stopped"):
        model_named(str(tmp_path / "fit"))


def test_grade_and_silence_of_every_target_and_the_status_are_data(fit, folder):
    content = json.loads((folder / "fit.json").read_text())
    assert content["status"] == list(fit.status)
    for entry, shown in zip(content["curves"], fit.curves, strict=True):
        assert entry["grade"] == shown.grade
        assert entry["rmse"]["silence"] == shown.rmse("silence") > 0
    for name in ("report.txt", "report.html"):
        assert "silence" in (folder / name).read_text(encoding="utf-8")


def test_the_old_name_of_the_notes_still_works(fit, tmp_path):
    with pytest.warns(DeprecationWarning, match=r"save_fit\(made=...\) is now save_fit\(notes=...\)"):
        lgmd.save_fit(fit, tmp_path / "old", made={"digest": "abc"})
    assert json.loads((tmp_path / "old/fit.json").read_text())["digest"] == "abc"


def test_intervals_state_their_confidence(folder):
    assert json.loads((folder / "fit.json").read_text())["uncertainty"]["confidence"] == 0.95


def test_curves_are_a_table(folder):
    with open(folder / "curves.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    columns = ["condition", "channel", "time_ms", "target", "sem", "weight", "soft", "hard", "band", "error"]
    assert list(rows[0]) == columns
    assert len(rows) == 90
    assert rows[0]["sem"] == ""
    assert rows[-1]["sem"] == "2"


def test_bands_come_back(fit, tmp_path):
    """Edges, also open ones, and words; beside them a curve stays a curve."""
    upper = np.where(np.arange(30) < 10, np.inf, 0.95)
    band = curve(target=np.where(np.arange(30) < 10, 0.5, -np.inf), upper=upper, quote='quiet, "weak" and brief')
    banded = dataclasses.replace(fit, curves=(band, curve(seed=1)))
    lgmd.save_fit(banded, tmp_path / "banded")
    again = lgmd.load_fit(tmp_path / "banded")
    assert again.curves[0].quote == band.quote
    np.testing.assert_array_equal(again.curves[0].target, band.target)
    np.testing.assert_array_equal(again.curves[0].upper, upper)
    assert not again.curves[1].is_band
    assert again.summary() == banded.summary()
    content = json.loads((tmp_path / "banded/fit.json").read_text())
    assert content["curves"][0]["within"]["hard"] == band.inside()
    assert "within" not in content["curves"][1]
    (words,) = content["words"]
    assert words["quote"] == band.quote
    assert words["samples"] == 30
    assert words["hard"] == band.inside()
    assert words["farthest"] == np.abs(band.distance()).max()


def test_soft_thresholds_come_back(fit, tmp_path):
    model = dataclasses.replace(fit.model, thresholds=lgmd.Soft(0.7))
    lgmd.save_fit(dataclasses.replace(fit, model=model), tmp_path / "soft")
    thresholds = lgmd.load_fit(tmp_path / "soft").model.thresholds
    assert isinstance(thresholds, lgmd.Soft)
    assert thresholds.temperature == 0.7


def changed(change):
    """Spoils the content of fit.json."""

    def spoil(folder):
        content = json.loads((folder / "fit.json").read_text())
        change(content)
        (folder / "fit.json").write_text(json.dumps(content))

    return spoil


def curve_cells(name, text):
    """Writes a text into the first cell of a column of curves.csv."""

    def spoil(folder):
        with open(folder / "curves.csv", newline="") as file:
            header, first, *rest = csv.reader(file)
        first[header.index(name)] = text
        with open(folder / "curves.csv", "w", newline="") as file:
            csv.writer(file).writerows([header, first, *rest])

    return spoil


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda folder: (folder / "fit.json").unlink(), "there is no fit.json"),
        (lambda folder: (folder / "fit.json").write_text("{}"), "no fit that can be used: fit.json: format is missing"),
        (changed(lambda content: content["free"]["tau1"].update(low="x")), r"free\.tau1\.low = 'x': must be a number"),
        (changed(lambda content: content["z"].pop()), "z has 2 values, but 3 parameters are free"),
        (changed(lambda content: content["curves"].pop()), "curves.csv holds other curves than fit.json names"),
        (
            changed(lambda content: content["uncertainty"]["covariance"][0].pop()),
            r"uncertainty.covariance does not have the shape \[3, 3\]",
        ),
        (curve_cells("hard", "x"), r"curves\.csv: \[0\]\.hard = 'x': must be a number"),
        (curve_cells("channel", "smpp"), r"curves\.csv: \[0\]\.channel = 'smpp': choose 'smp'"),
        (
            lambda folder: (folder / "curves.csv").write_text("a,b\n1,2\n"),
            r"curves\.csv: \[0\]\.a = 1.0: unknown key; did you mean",
        ),
        (lambda folder: (folder / "fit.json").write_text("{"), r"fit\.json is not a JSON file"),
        (lambda folder: (folder / "model.json").write_text("{}"), "not a hand-over file"),
    ],
)
def test_a_spoilt_folder_is_refused(folder, tmp_path, spoil, message):
    folder = shutil.copytree(folder, tmp_path / "fit")
    spoil(folder)
    with pytest.raises(ValueError, match=message):
        lgmd.load_fit(folder)


def test_a_folder_that_is_not_there_names_the_shipped_ones():
    with pytest.raises(FileNotFoundError, match="dcmd"):
        lgmd.load_fit("dmcd")
