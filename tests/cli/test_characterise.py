"""`lgmd2jax characterise`: models by name, results in a table and in files, one line for a mistake."""

import json

import pytest

import lgmd2jax as lgmd
from lgmd2jax._characterise.measurements import result_of
from lgmd2jax.cli import characterise as command, main
from tests.characterise.signals import EXAM, examine, ideal
from tests.fitting.fits import fit_with

EYE = lgmd.Eye(rows=32, cols=42, degrees_per_pixel=3.0, fps=50.0)


@pytest.fixture(scope="module")
def found():
    return result_of(EXAM, "LGMD2", examine(ideal()))


@pytest.fixture(scope="module")
def mine(tmp_path_factory):
    """A hand-over file of an eye that is no preset's."""
    path = tmp_path_factory.mktemp("mine") / "model.json"
    lgmd.save(lgmd.LGMD2(eye=EYE), path)
    return path


@pytest.fixture
def shown(monkeypatch, found):
    """The models that the exam is asked about, which is not held: the answers are made up."""
    models = []

    def answer(model, **_):
        models.append(model)
        return found

    def variants(model, *mechanisms, seeds=0, **_):
        named = {f"without {name}": found for name in mechanisms} | {f"noise {i}": found for i in range(seeds)}
        return {"as it is": answer(model), "else": found, **named}

    monkeypatch.setattr(command, "characterise", answer)
    monkeypatch.setattr(command, "ablations", variants)
    monkeypatch.setattr(command, "rasters", variants)
    return models


def test_models_side_by_side(shown, tmp_path, capsys):
    files = [str(tmp_path / name) for name in ("a.json", "a.png")]
    assert main(["characterise", "preset:lgmd2", "preset:balanced", "--json", files[0], "--figure", files[1]]) == 0
    out = capsys.readouterr().out
    assert "preset:lgmd2" in out
    assert "preset:balanced" in out
    assert out.splitlines()[-1] == f"wrote {files[0]}, {files[1]}"
    content = json.loads((tmp_path / "a.json").read_text())
    assert list(content["models"]) == ["preset:lgmd2", "preset:balanced"]
    assert len(content["models"]["preset:lgmd2"]["rows"]) == 22
    assert sorted(it.name for it in tmp_path.iterdir()) == ["a.json", "a.png"]


def test_a_preset_is_given_the_eye_of_a_locust_and_its_frame_rate(shown):
    assert main(["characterise", "preset:lgmd2"]) == 0
    (model,) = shown
    assert model.eye == lgmd.Eye.preset("locust")
    assert float(model.parameters.T_ffi) == pytest.approx(3)
    assert float(model.parameters.sigma1) == pytest.approx(0.1**0.3)


def test_a_file_keeps_its_eye(shown, mine):
    assert main(["characterise", str(mine)]) == 0
    assert shown[0].eye == EYE
    assert float(shown[0].parameters.T_ffi) == 10


@pytest.mark.parametrize("option", ["--ablate", "--raster"])
def test_variants_of_one_model(shown, option, capsys):
    assert main(["characterise", "preset:lgmd2", option]) == 0
    out = capsys.readouterr().out
    assert "else" in out
    assert ("alpha shifts by +0.00; verdicts that change: none" in out) == (option == "--raster")
    assert main(["characterise", "preset:lgmd2", "preset:balanced", option]) == 1
    assert capsys.readouterr().err == f"lgmd2jax: {option} takes one model; give the others by themselves\n"


def test_mechanisms_and_seeds_are_chosen(shown, capsys):
    assert main(["characterise", "preset:lgmd2", "--ablate", "sfa", "on"]) == 0
    head = capsys.readouterr().out.splitlines()[0]
    assert "without sfa" in head
    assert "without on" in head
    assert main(["characterise", "preset:lgmd2", "--raster", "--seeds", "2"]) == 0
    assert "noise 1" in capsys.readouterr().out.splitlines()[0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["preset:lgmd2", "--seeds", "2"], "--seeds draws other noise for --raster; add --raster"),
        (["preset:lgmd2", "--ablate", "sizes"], "mechanism is 'sizes'; choose"),
        (["preset:lgmd3"], "lgmd2"),
        (["nothing.json"], "no such file: nothing.json"),
        (["preset:lgmd2", "preset:lgmd2"], "named twice"),
        (["preset:lgmd2", "--figure", "a.xyz"], "cannot tell the format"),
        (["preset:lgmd2", "--json", "nowhere/a.json"], "folder nowhere does not exist"),
    ],
)
def test_mistakes_are_told_in_one_line(arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["characterise", *arguments]) == 1
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_model_without_an_eye_leaves_no_file(mine, tmp_path, capsys):
    blind = json.loads(mine.read_text()) | {"eye": None}
    (tmp_path / "mine.json").write_text(json.dumps(blind))
    assert main(["characterise", str(tmp_path / "mine.json"), "--json", str(tmp_path / "a.json")]) == 1
    assert "the model has no eye" in capsys.readouterr().err
    assert [it.name for it in tmp_path.iterdir()] == ["mine.json"]


def test_intervals_are_asked_of_the_fit_beside_the_model(shown, mine, tmp_path, monkeypatch, capsys):
    asked = []
    monkeypatch.setattr(
        command, "load_fit", lambda folder: asked.append(folder) or fit_with(lgmd.Free(tau2=(20, 300)), [])
    )
    (tmp_path / "model.json").write_bytes(mine.read_bytes())
    assert main(["characterise", str(tmp_path / "model.json"), "--intervals"]) == 0
    assert asked == []
    assert (
        f"warning: {tmp_path / 'model.json'} has no intervals: no fit to curves lies beside it"
        in capsys.readouterr().err
    )
    (tmp_path / "fit.json").write_text("{}")
    assert main(["characterise", str(tmp_path / "model.json"), "--intervals"]) == 0
    assert asked == [tmp_path]
    assert capsys.readouterr().err == ""
    assert isinstance(shown[1], lgmd.Fit)
