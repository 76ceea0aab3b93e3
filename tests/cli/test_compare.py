"""`lgmd2jax compare`: fits side by side as a table and as files, one line for a mistake."""

import json
import shutil

import pytest

import lgmd2jax as lgmd
from lgmd2jax.cli import main
from lgmd2jax.fitting import Free
from tests.fitting.fits import curve, fit_with


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    place = tmp_path_factory.mktemp("results")
    for name, free, shown in (("a", "tau1", "loom"), ("b", "tau3", "loom"), ("c", "tau3", "another loom")):
        lgmd.save_fit(fit_with(Free(**dict.fromkeys(("theta2", free))), [curve(shown)]), place / name)
    return place


def test_table_and_files(folders, tmp_path, capsys):
    files = [str(tmp_path / f"all.{suffix}") for suffix in ("json", "csv", "png")]
    options = ["--json", files[0], "--csv", files[1], "--figure", files[2]]
    assert main(["compare", str(folders / "a"), str(folders / "b"), *options]) == 0
    out = capsys.readouterr().out
    assert out.startswith("Fits side by side")
    assert out.splitlines()[-1] == "wrote " + ", ".join(files)
    assert list(json.loads((tmp_path / "all.json").read_text())["fits"]) == ["a", "b"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["all.csv", "all.json", "all.png"]


def test_fits_of_one_name_go_by_their_paths(folders, tmp_path, capsys):
    shutil.copytree(folders / "b", tmp_path / "a")
    assert main(["compare", str(folders / "a"), str(tmp_path / "a"), "--json", str(tmp_path / "all.json")]) == 0
    assert list(json.loads((tmp_path / "all.json").read_text())["fits"]) == [str(folders / "a"), str(tmp_path / "a")]
    capsys.readouterr()
    assert main(["compare", str(folders / "a"), str(folders / "a")]) == 1
    assert f"{folders / 'a'} is given 2 times; give each fit once" in capsys.readouterr().err


def test_other_data_are_one_line_and_nothing_is_written(folders, tmp_path, capsys):
    assert main(["compare", str(folders / "a"), str(folders / "c"), "--json", str(tmp_path / "all.json")]) == 1
    error = capsys.readouterr().err
    assert "a and c are fits to different data: 'loom', smp_adapted, is a target of a alone" in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())
