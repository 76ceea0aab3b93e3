"""A recipe that asks for one fit an animal."""

import csv
import json

import pytest

import lgmd2jax as lgmd
from lgmd2jax._files.lock import locked
from lgmd2jax._recipes.fit import Recipe
from lgmd2jax.cli import main
from lgmd2jax.cli.fit import folder_names

PROTOCOL = """
[eye]
rows = 8
cols = 10
degrees_per_pixel = 8
fps = 60
[[condition]]
name = "loom {l_over_v}"
family = "looming"
l_over_v = [20, 40]
contrast = -0.9
start_ms = -300
end_ms = 150
[[condition.target]]
spikes = "spikes.csv"
likelihood = "poisson"
where = { l_over_v = "{l_over_v}" }
"""
RECIPE = """
protocol = "mine.toml"
by = "animal"
temperature = 1.0
[parameters]
T_s = 5
[free]
gain = {}
baseline = {}
[solver]
pixel_points = 1
cell_points = 16
descend = 1
"""
# Animal C was shown one stimulus alone.
SPIKES = [
    (animal, speed, trial, time)
    for animal, speeds in {"A": (20, 40), "B/1": (20, 40), "C": (20,)}.items()
    for speed in speeds
    for trial in (1, 2)
    for time in (-120 + 5 * trial, -40, -20 + trial, 0, 15, 60, 70 + trial)
]


@pytest.fixture
def recipe(tmp_path):
    with open(tmp_path / "spikes.csv", "w", newline="") as file:
        csv.writer(file).writerows([("animal", "l_over_v", "trial", "time_ms"), *SPIKES])
    (tmp_path / "mine.toml").write_text(PROTOCOL)
    (tmp_path / "recipe.toml").write_text(RECIPE)
    return tmp_path / "recipe.toml"


def test_each_animal_has_its_own_trials_and_conditions(recipe):
    whole = lgmd.load_recipe(recipe)
    assert isinstance(whole, Recipe)
    own = whole.each()
    assert list(own) == ["A", "B/1", "C"]
    assert [stimulus.name for stimulus, _ in own["C"].pairs] == ["loom 20"]
    assert own["C"].families == ("looming",)
    for animal, each in own.items():
        for _, (target,) in each.pairs:
            assert target.exposure is not None
            assert target.exposure[0] == pytest.approx(2 / 60), animal
    assert own["A"].digest() != own["C"].digest()


def test_two_fits_do_not_mix_their_animals_in_one_folder(recipe, capsys):
    with locked(recipe.parent / "results"):
        assert main(["fit", str(recipe), "-o", str(recipe.parent / "results")]) == 1
    assert "results is in use by process" in capsys.readouterr().err
    assert not (recipe.parent / "results").exists()


@pytest.mark.slow
def test_the_command_leaves_a_folder_an_animal_and_what_holds_over_them(recipe, capsys):
    folder = recipe.parent / "results"
    assert main(["fit", str(recipe), "-o", str(folder)]) == 0
    assert "3 animals, a fit each" in capsys.readouterr().out
    assert {"A", "B_1", "C", "animals.csv", "animals.png", "report.txt"} <= {path.name for path in folder.iterdir()}
    data = json.loads((folder / "A/fit.json").read_text())["data"]
    assert data == {"protocol": "../../mine.toml", "animal": "A"}
    again = lgmd.load_fit(folder / "A")
    assert again._problem("test").samples() == again.uncertainty.n_effective  # of the trials of A alone


def test_no_two_animals_share_a_folder():
    assert folder_names(["a b", "a_b", "A/b", "..", ".", "", "report.txt", "G11", "Käfer 1"]) == [
        "a_b", "a_b_", "A_b__", "_", "__", "___", "report.txt_", "G11", "Käfer_1"
    ]  # fmt: skip
