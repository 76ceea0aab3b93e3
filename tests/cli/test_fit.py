"""`lgmd2jax fit` and `lgmd2jax predict`, from a recipe to a folder and on to other stimuli."""

import csv
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax import hard
from lgmd2jax.cli import main
from tests.documents import FREE_K_AND_TAU3, TWO_LOOMS

RECIPE = f"""{FREE_K_AND_TAU3}
[solver]
pixel_points = 4
cell_points = 64
descend = 2
temperatures = [0.5, 0.1]
seed = 3
[uncertainty]
profile = ["k"]
[truth]
k = 0.4
tau3 = 250
"""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fit")
    (folder / "looms.toml").write_text(TWO_LOOMS)
    (folder / "recipe.toml").write_text(RECIPE)
    return folder


@pytest.fixture(scope="module")
def results(place):
    assert main(["fit", str(place / "recipe.toml")]) == 0
    return place / "recipe"


def test_the_folder_stands_beside_the_recipe(results):
    assert {path.name for path in results.iterdir()} == {
        "model.json", "fit.json", "curves.csv", "fit.png", "diagnostics.png", "report.txt", "report.html",
    }  # fmt: skip
    assert not list(results.parent.glob(".*"))


def test_the_report_has_what_the_recipe_asked_for(results):
    report, content = (results / "report.txt").read_text(), json.loads((results / "fit.json").read_text())
    for part in ("Known truth", "Profile-likelihood"):
        assert part in report
    low, high = content["profiles"]["k"]["interval"]
    assert low < content["free"]["k"]["value"] < high
    assert content["recipe"]["solver"]["seed"] == 3
    assert {"jax", "optimistix", "lgmd2jax"} <= set(content["versions"])


def test_the_robots_model_gives_the_curves(results):
    with open(results / "curves.csv", newline="") as file:
        written = [float(row["hard"]) for row in csv.DictReader(file) if row["condition"] == "loom 20"]
    stimulus = lgmd.load_protocol(results.parent / "looms.toml").conditions[0].render()
    robot = hard.load(results / "model.json")
    np.testing.assert_allclose(robot(np.asarray(stimulus.frames), 50.0).smp_adapted, written, atol=1e-7)


def test_the_same_recipe_gives_the_same_bytes(place, results):
    assert main(["fit", str(place / "recipe.toml"), "-o", str(place / "again")]) == 0
    assert (place / "again" / "model.json").read_bytes() == (results / "model.json").read_bytes()
    assert (place / "again" / "fit.png").read_bytes() == (results / "fit.png").read_bytes()


def test_predict_writes_the_fitted_channel(place, results, capsys):
    output = place / "predicted.csv"
    assert main(["predict", str(results), str(place / "looms.toml"), "-o", str(output)]) == 0
    assert "smp_adapted of 2 conditions" in capsys.readouterr().out
    with open(output, newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["condition", "time_ms", "value"]
    with open(results / "curves.csv", newline="") as file:
        fitted = [float(row["hard"]) for row in csv.DictReader(file)]
    np.testing.assert_allclose([float(row["value"]) for row in rows], fitted, atol=1e-7)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("k = {", "q = {"), "free.q = {"),
        (("[free]", "[fee]"), ": unknown key; did you mean 'free'"),
        (("looms.toml", "other.toml"), "no such file: other.toml"),
        (("seed = 3", "seeds = 3"), "solver.seeds = 3: unknown key; did you mean 'seed'"),
        (("high = 2,", "high = 0.3,"), "k starts at 1, outside of its bounds"),
        (('"log"', '"loog"'), "free.k.scale = 'loog': choose 'log' or 'linear'"),
        (('["k"]', '["T_sp"]'), "'T_sp' is not free"),
        (("T_s = 5", "T_s = -5"), "parameters.T_s = -5: must be 0 or more"),
        (("pixel_points = 4", "pixel_points = 0"), "solver.pixel_points = 0: must be 1 or more"),
    ],
)
def test_a_wrong_recipe_is_one_line_and_nothing_is_written(place, capsys, change, message):
    wrong = place / "wrong.toml"
    wrong.write_text(RECIPE.replace(*change))
    assert main(["fit", str(wrong)]) == 1
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not (place / "wrong").exists()
    assert not list(place.glob(".*"))


def test_a_folder_of_something_else_is_refused_before_the_work(place, capsys):
    other = place / "precious"
    other.mkdir()
    (other / "data.txt").write_text("keep")
    assert main(["fit", str(place / "recipe.toml"), "-o", str(other)]) == 1
    assert "something else than results" in capsys.readouterr().err
    assert [path.name for path in other.iterdir()] == ["data.txt"]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals are for POSIX systems")
@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGKILL])
def test_a_stopped_fit_goes_on_with_resume(place, results, kind):
    (place / "long.toml").write_text(RECIPE.replace("pixel_points = 4", "pixel_points = 400"))
    folder, starts = place / f"stopped{kind}", place / f".stopped{kind}.starts.jsonl"
    command = [sys.executable, "-m", "lgmd2jax.cli", "fit", str(place / "long.toml"), "-o", str(folder)]
    environment = os.environ | {"JAX_PLATFORMS": "cpu"}
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        while not (starts.exists() and starts.read_text().count("\n") > 20):
            time.sleep(0.05)
        process.send_signal(kind)
        process.communicate()
    if kind == signal.SIGINT:
        assert process.returncode == 130
        assert "stopped by hand" in (folder / "report.txt").read_text()
    else:
        assert not folder.exists()
    assert starts.exists()
    subprocess.run([*command, "--resume"], env=environment, check=True, capture_output=True)
    whole = place / "whole"
    if not whole.exists():
        subprocess.run([*command[:-1], str(whole)], env=environment, check=True, capture_output=True)
    assert (folder / "model.json").read_bytes() == (whole / "model.json").read_bytes()
    assert not starts.exists()
