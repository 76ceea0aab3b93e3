"""Files that version 0.1.0 wrote are read today.

`release_0_1.zip` holds what commands of 0.1.0 (commit 4b5c816) left: results of a fit to curves (`fit`), of a fit to
labelled clips (`alarms`) and of a sweep (`sweep`), with the recipes, protocol, labels and clips that they came from.
"""

import json
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest
import xarray

import lgmd2jax as lgmd
from lgmd2jax import hard
from lgmd2jax._recipes.sweep import SweepRecipe
from lgmd2jax.cli import main

ARCHIVE = Path(__file__).with_name("release_0_1.zip")
EYE = lgmd.Eye(rows=12, cols=16, degrees_per_pixel=8.0, fps=30.0)


@pytest.fixture(scope="module")
def old(tmp_path_factory) -> Path:
    """The files of version 0.1.0, unpacked."""
    folder = tmp_path_factory.mktemp("release")
    with zipfile.ZipFile(ARCHIVE) as archive:
        archive.extractall(folder)
    return folder


@pytest.mark.parametrize("name", ["fit", "alarms"])
def test_a_model_loads_in_jax_and_on_the_robot(old, name):
    file = old / name / "model.json"
    written = json.loads(file.read_text(encoding="utf-8"))
    assert written["version"] == 1
    model, robot = lgmd.load(file), hard.load(file)
    values = written["parameters"]
    assert {key: float(getattr(model.parameters, key)) for key in values} == values
    frames = np.asarray(lgmd.stimuli.looming(EYE, l_over_v=40.0, start_ms=-300.0, end_ms=60.0).frames)
    np.testing.assert_allclose(robot(frames).smp_adapted, model(frames, 30.0).smp_adapted, atol=1e-6)


def test_a_fit_loads_with_its_values_and_curves(old):
    fit = lgmd.load_fit(old / "fit")
    written = json.loads((old / "fit/fit.json").read_text(encoding="utf-8"))
    assert dict(fit.values) == {name: found["value"] for name, found in written["free"].items()}
    assert [curve.condition for curve in fit.curves] == ["approach, l/|v| 20", "approach, l/|v| 40"]
    loom = lgmd.load_protocol(old / "small.toml").conditions[1]
    np.testing.assert_allclose(fit.predict(loom.render()), fit.curves[1].soft, atol=1e-6)  # thresholds are soft


def test_fits_are_compared_without_the_errors_that_they_do_not_hold(old, tmp_path, capsys):
    shutil.copytree(old / "fit", tmp_path / "again")
    figure = tmp_path / "both.png"
    assert main(["compare", str(old / "fit"), str(tmp_path / "again"), "--figure", str(figure)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "The chi2 of fit is not known, since results of version 0.1 lack the errors of targets; fit again" in said
    assert figure.is_file()


def test_recipes_and_protocol_load(old):
    for name, free in (("fit.toml", ("theta2", "k")), ("alarms.toml", ("k", "T_sp"))):
        recipe = lgmd.load_recipe(old / name)
        assert not isinstance(recipe, SweepRecipe)
        assert recipe.free.names == free
    assert isinstance(lgmd.load_recipe(old / "sweep.toml"), SweepRecipe)
    assert len(lgmd.load_protocol(old / "small.toml").conditions) == 2


def test_labels_load_with_their_clips(old):
    clips = {clip.name: clip for clip in lgmd.alarms.load_labels(old / "labels.toml").load()}
    assert len(clips) == 6  # two of files, four rendered
    assert clips["loom"].windows == ((20, 32),)
    assert clips["loom"].contact == 32
    assert clips["away"].silent == ((5, 32),)


def test_a_sweep_is_read_and_not_resumed(old, capsys):
    store = xarray.open_zarr(old / "sweep/sweep.zarr", consolidated=False)
    assert store.peak.dims == ("contrast", "l_over_v")
    assert np.isfinite(store.peak.values).all()
    assert main(["sweep", str(old / "sweep.toml")]) == 1
    said = capsys.readouterr().err
    assert "holds another sweep (or one of other versions); remove it, or name another folder" in said


def test_results_of_a_fit_to_clips_are_told_from_those_of_a_fit_to_curves(old):
    with pytest.raises(ValueError, match=r"holds a fit to labelled clips, and .* lgmd2jax\.load\(.*model\.json"):
        lgmd.load_fit(old / "alarms")
