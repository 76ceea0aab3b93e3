"""`lgmd2jax fit` from end to end, and the recipes and targets that it refuses."""

import csv
import json

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax import hard
from lgmd2jax.cli import main
from lgmd2jax.fitting import Observation, read_target

PROTOCOL = """
[eye]
rows = 12
cols = 16
degrees_per_pixel = 6.0
fps = 60
[[condition]]
name = "loom"
family = "looming"
l_over_v = 20
start_ms = -400
end_ms = 200
[[condition.target]]
channel = "rate"
interpolate = true
file = "curve.csv"
column = "rate"
"""
RECIPE = """
protocol = "protocol.toml"
[parameters]
tau2 = 800
[observation]
gain = 60.0
[free]
k = { low = 0.05, high = 2.0 }
[solver]
temperatures = [0.3]
"""


@pytest.fixture
def folder(tmp_path):
    """A recipe, its protocol and a curve that rises and falls."""
    time = np.arange(-500, 300, 5.0)
    rate = 5 + 60 * np.exp(-(((time + 50) / 80) ** 2))
    (tmp_path / "protocol.toml").write_text(PROTOCOL)
    (tmp_path / "recipe.toml").write_text(RECIPE)
    rows = "\n".join(f"{t},{r}" for t, r in zip(time, rate, strict=True))
    (tmp_path / "curve.csv").write_text(f"t_ms,rate\n{rows}\n")
    return tmp_path


def test_fit_writes_a_model_that_numpy_runs(folder, capsys):
    assert main(["fit", str(folder / "recipe.toml")]) == 0
    out = folder / "recipe"
    assert sorted(file.name for file in out.iterdir()) == ["curves.csv", "fit.json", "fit.png", "model.json"]
    summary = json.loads((out / "fit.json").read_text())
    assert f"{summary['free']['k']['value']:.4g}" in capsys.readouterr().out
    assert hard.load(out / "model.json").parameters["k"] == summary["free"]["k"]["value"]
    assert hard.load(out / "model.json").parameters["tau2"] == 800

    stimulus = lgmd.load_protocol(folder / "protocol.toml").conditions[0].render()
    potential = hard.load(out / "model.json")(np.asarray(stimulus.frames)).smp_adapted
    expected = Observation(gain=60.0)(potential, stimulus.time)
    with open(out / "curves.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    np.testing.assert_allclose([float(row["hard"]) for row in rows], expected, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose([float(row["time_ms"]) for row in rows], stimulus.time, rtol=1e-5)
    r2 = summary["r2"]["loom"]
    assert r2["hard"] > 0.5


def test_the_same_recipe_gives_the_same_files(folder):
    for name in ("one", "two"):
        assert main(["fit", str(folder / "recipe.toml"), "-o", str(folder / name)]) == 0
    for file in ("model.json", "curves.csv", "fit.json", "fit.png"):
        assert (folder / "one" / file).read_bytes() == (folder / "two" / file).read_bytes()


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        ("recipe.toml", 'protocol = "protocol.toml"', "", "protocol is missing"),
        ("recipe.toml", "protocol.toml", "nowhere.toml", "nowhere.toml"),
        ("recipe.toml", "[free]", "[fre]", "unknown key 'fre'; did you mean 'free'"),
        ("recipe.toml", "k = {", "kk = {", "unknown key 'kk'; did you mean 'k'"),
        ("recipe.toml", "low = 0.05", "lower = 0.05", "unknown key 'lower'; did you mean 'low'"),
        ("recipe.toml", "low = 0.05", "low = 3", "first bound must be below"),
        ("recipe.toml", "tau2 = 800", "tau2 = -1", "tau2 is -1 ms"),
        ("recipe.toml", "gain = 60.0", "gian = 60.0", "unknown key 'gian'; did you mean 'gain'"),
        ("recipe.toml", "gain = 60.0", "gain = 'much'", "gain is 'much'"),
        ("recipe.toml", "[free]", "free]", "is not a TOML file"),
        ("protocol.toml", 'column = "rate"', 'column = "rat"', "no column 'rat'; there are t_ms, rate"),
        ("protocol.toml", 'file = "curve.csv"', "", "its target has no file"),
        ("curve.csv", "-500.0,", "-500.0,nan\n-499,", "not a finite number"),
        ("curve.csv", "-500.0,", "600.0,1\n-499,", "do not increase"),
    ],
)
def test_what_is_not_in_order_is_refused_in_one_line(folder, capsys, file, old, new, message):
    (folder / "recipe").mkdir()
    (folder / "recipe" / "model.json").write_text("the old one")
    text = (folder / file).read_text()
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1))
    assert main(["fit", str(folder / "recipe.toml")]) == 1
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert [path.name for path in (folder / "recipe").iterdir()] == ["model.json"]
    assert (folder / "recipe" / "model.json").read_text() == "the old one"


def test_a_target_is_interpolated_and_weighs_nothing_outside(folder):
    (folder / "short.csv").write_text("t_ms,a,e\n0,1,0.1\n10,3,0.3\n")
    target = read_target(folder / "short.csv", "a", np.array([-5.0, 0.0, 5.0, 10.0, 15.0]), "e")
    np.testing.assert_array_equal(target.weight, [0, 1, 1, 1, 0])
    np.testing.assert_allclose(target.values[1:4], [1, 2, 3])
    assert target.sem is not None
    np.testing.assert_allclose(target.sem[1:4], [0.1, 0.2, 0.3])


def test_the_shipped_fit_is_the_one_that_the_recipe_makes(tmp_path):
    """What lies in fits/dcmd comes from fits/dcmd.toml, and describes the recording."""
    from lgmd2jax._catalogue import folder

    assert main(["fit", "dcmd", "-o", str(tmp_path / "dcmd")]) == 0
    made, shipped = (json.loads((place / "dcmd" / "fit.json").read_text()) for place in (tmp_path, folder("fits")))
    for name, entry in shipped["free"].items():
        np.testing.assert_allclose(made["free"][name]["value"], entry["value"], rtol=1e-3)
    for r2 in made["r2"].values():
        assert r2["hard"] > 0.95
