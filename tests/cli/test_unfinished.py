"""A fit that is stopped in any part: what is finished is in its folder, marked, and `--resume` does the rest."""

import json

import numpy as np
import pytest
import xarray

import lgmd2jax as lgmd
from lgmd2jax._compute.finished_work import FileMemory
from lgmd2jax._files.lock import locked
from lgmd2jax._words import UnfinishedWarning
from lgmd2jax.cli import main
from tests.documents import FREE_K_AND_TAU3, TWO_LOOMS

RECIPE = f"""{FREE_K_AND_TAU3}
[solver]
pixel_points = 2
cell_points = 16
descend = 1
temperatures = [0.5]
[uncertainty]
profile = ["k"]
samples = 4
[validation]
leave_one_out = true
"""
EQUAL = ("model.json", "curves.csv", "report.txt", "report.html", "fit.png", "diagnostics.png")
LEFT_OUT = [f"the prediction of 'loom {speed}' by a fit to the others" for speed in (20, 40)]
DRAWS = "the draws of the posterior"


def chain(residuals, start, key, variance, draws, warmup, bar):
    """In place of the sampler, which takes long to compile."""
    x = np.asarray(start) + 0.01 * np.arange(draws)[:, None]
    return [array.tolist() for array in (x, x[:, 0], x[:, 0] > 9, x[:, 0], np.ones(draws, int))]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with a recipe and the results of an undisturbed run."""
    folder = tmp_path_factory.mktemp("unfinished")
    (folder / "looms.toml").write_text(TWO_LOOMS)
    (folder / "recipe.toml").write_text(RECIPE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lgmd2jax.fitting._uncertainty.posterior._chain", chain)
        assert main(["fit", str(folder / "recipe.toml")]) == 0
        yield folder


def stop_after(monkeypatch, key):
    """Press Ctrl-C once this entry of the finished work is written."""
    write = FileMemory.__setitem__

    def stopped(self, name, value):
        write(self, name, value)
        if name.startswith(key):
            raise KeyboardInterrupt

    monkeypatch.setattr(FileMemory, "__setitem__", stopped)


@pytest.mark.parametrize(
    ("key", "left"),
    [
        ("screening 0", ["the search", "the score test", "the profile of k", *LEFT_OUT, DRAWS]),
        ("profile of k", ["the profile of k", *LEFT_OUT, DRAWS]),
        pytest.param("without loom 20: screening 0", [*LEFT_OUT, DRAWS], marks=pytest.mark.slow),
        ("without loom 20", [*LEFT_OUT, DRAWS]),
        pytest.param("chain 0", [DRAWS], marks=pytest.mark.slow),
    ],
)
def test_a_part_that_is_stopped_is_named_and_gone_on_with(place, tmp_path, capsys, monkeypatch, untyped, key, left):
    command, folder = ["fit", str(place / "recipe.toml"), "-o", str(tmp_path / "it")], tmp_path / "it"
    with monkeypatch.context() as patch:
        stop_after(patch, key)
        with pytest.raises(SystemExit, match="130"):
            main(command)
    assert "continue with --resume" in capsys.readouterr().out
    assert json.loads((folder / "fit.json").read_text())["unfinished"] in (left, ["the figures", *left])
    for report in ("report.txt", "report.html"):
        assert "UNFINISHED" in (folder / report).read_text()
    with pytest.warns(UnfinishedWarning, match="is unfinished"):
        assert lgmd.load_fit(folder).values
    if key != "screening 0":
        assert (folder / "model.json").read_bytes() == (place / "recipe/model.json").read_bytes()
    assert main(["export", str(folder / "model.json"), "--python", str(tmp_path / "robot")]) == 0
    assert ("is of an unfinished fit" in capsys.readouterr().err) == (key == "screening 0")

    assert main([*command, "--resume"]) == 0
    for name in EQUAL:
        assert (folder / name).read_bytes() == (place / "recipe" / name).read_bytes(), name
    drawn, expected = (
        xarray.load_dataset(path / "posterior.nc", group="posterior", engine="h5netcdf")
        for path in (folder, place / "recipe")
    )
    assert drawn.equals(expected)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["it", "robot"]


def test_a_stopped_search_does_not_take_the_place_of_finished_results(place, capsys, monkeypatch, untyped):
    before = {path.name: path.read_bytes() for path in (place / "recipe").iterdir()}
    with monkeypatch.context() as patch:
        stop_after(patch, "screening 0")
        with pytest.raises(SystemExit, match="130"):
            main(["fit", str(place / "recipe.toml")])
    assert "keeps the finished results of an earlier run" in capsys.readouterr().out
    assert {path.name: path.read_bytes() for path in (place / "recipe").iterdir()} == before


def test_a_folder_in_use_is_refused_in_one_line(place, capsys, untyped):
    names = sorted(path.name for path in place.iterdir())
    with locked(place / "recipe"):
        assert main(["fit", str(place / "recipe.toml"), "--resume"]) == 1
    said = capsys.readouterr().err
    assert "is in use by process" in said
    assert said.count("\n") == 1
    assert sorted(path.name for path in place.iterdir()) == names
