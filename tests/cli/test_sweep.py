"""`lgmd2jax sweep`, from a recipe to a store and a figure, and what is wrong with a recipe, in one line."""

import imageio.v3 as iio
import matplotlib as mpl
import numpy as np
import pytest
import xarray

import lgmd2jax as lgmd
from lgmd2jax._recipes.load import load_recipe
from lgmd2jax.cli import main

RECIPE = """
kind = "sweep"
family = "looming"
[eye]
rows = 10
cols = 12
degrees_per_pixel = 8
fps = 50
[stimulus]
contrast = [-0.9, 0.2]
background = 120
l_over_v = { from = 10, to = 40, count = 3, spacing = "log" }
start_ms = -400
end_ms = 60
[parameters]
theta1 = [0, 1, 2]
[figure]
value = "peak"
index = "contrast"
"""


@pytest.fixture
def recipe(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(RECIPE)
    return path


def test_a_recipe_becomes_a_store_and_a_figure(recipe, capsys, monkeypatch):
    assert main(["sweep", str(recipe)]) == 0
    folder = recipe.with_suffix("")
    assert f"wrote {folder}/ (3 theta1 x 2 contrast x 3 l_over_v)" in capsys.readouterr().out
    assert sorted(path.name for path in folder.iterdir()) == ["sweep.png", "sweep.zarr"]
    found = xarray.open_zarr(folder / "sweep.zarr", chunks=None, consolidated=False)
    np.testing.assert_allclose(found.l_over_v, [10, 20, 40])
    eye = lgmd.Eye(rows=10, cols=12, degrees_per_pixel=8.0, fps=50.0)
    shown = lgmd.stimuli.looming(eye, contrast=0.2, background=120.0, l_over_v=20.0, start_ms=-400.0, end_ms=60.0)
    response = lgmd.LGMD2(lgmd.Parameters(theta1=1.0))(shown.frames, 50.0)
    at = found.sel(theta1=1.0, contrast=0.2).isel(l_over_v=1)
    np.testing.assert_allclose(at.peak, response.smp_adapted.max(), rtol=1e-9)
    dark, light = found.peak.sel(theta1=0.0).isel(l_over_v=0).values
    colour = mpl.colormaps["PuOr_r"](((dark - light) / (dark + light) + 1) / 2)
    pixels = iio.imread(folder / "sweep.png")
    assert np.all(np.abs(pixels - 255 * np.array(colour)) < 2, axis=-1).mean() > 0.05  # a third of the surface
    monkeypatch.setattr("lgmd2jax._sweep.blocks.Plan.compute", None)  # all is there already
    assert main(["sweep", str(recipe)]) == 0


def test_ctrl_c_says_how_to_go_on(recipe, capsys, monkeypatch):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("lgmd2jax._recipes.sweep.sweep", stopped)
    with pytest.raises(SystemExit, match="130"):
        main(["sweep", str(recipe)])
    assert "keeps what is finished: run again" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["contrast_speed", "gratings", "parameters"])
def test_shipped_recipes_load(name):
    recipe = load_recipe(name)
    assert isinstance(recipe, lgmd.SweepRecipe)
    assert recipe.value in ("peak", "integral")


def test_the_thresholds_drawn_are_those_of_the_network(recipe):
    surface = RECIPE.replace("[parameters]\ntheta1 = [0, 1, 2]\n", "").replace('index = "contrast"', "")
    for name, levels in (("lgmd2", {"1 spike": 0.78, "2 spikes": 0.88}), ("yue_rind", {"1 spike": 0.86})):
        recipe.write_text(f'model = "preset:{name}"\n{surface}')
        surface_recipe = load_recipe(recipe)
        assert isinstance(surface_recipe, lgmd.SweepRecipe)
        assert surface_recipe.thresholds() == pytest.approx(levels)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"sweep"', '"sweeps"', "kind = 'sweeps': choose 'sweep'"),
        ('"looming"', '"loming"', "family = 'loming': choose 'looming'"),
        ("contrast = [", "contrst = [", "stimulus.contrst = [-0.9, 0.2]: unknown key; did you mean 'contrast'?"),
        ("theta1", "theta9", "parameters.theta9 = [0, 1, 2]: unknown key; did you mean 'theta"),
        ('"log"', '"logarithmic"', "stimulus.l_over_v.spacing = 'logarithmic': choose 'log' or 'linear'"),
        ("count = 3", "count = 0", "stimulus.l_over_v.count = 0: must be 1 or more"),
        ("[-0.9, 0.2]", "[-0.9, nan]", "stimulus.contrast[1] = nan: must be a finite number"),
        ("[-0.9, 0.2]", "[]", "stimulus.contrast = []: must hold 1 or more values"),
        ("[parameters]\ntheta1 = [0, 1, 2]", "[[parameters]]", "parameters = [{}]: must be a table"),
        ('"peak"', '"peek"', "figure.value = 'peek': choose 'peak'"),
        ('index = "contrast"', 'index = "theta1"', "which is not an axis of two values"),
        ('index = "contrast"', "", "figure: the axes are theta1, contrast, l_over_v"),
    ],
)
def test_a_bad_recipe_is_one_line_and_writes_nothing(recipe, capsys, untyped, old, new, message):
    recipe.write_text(RECIPE.replace(old, new))
    assert main(["sweep", str(recipe)]) == 1
    said = capsys.readouterr().err
    assert message in said
    assert str(recipe) in said
    assert said.count("\n") == 1
    assert [path.name for path in recipe.parent.iterdir()] == ["mine.toml"]


def test_a_sweep_that_was_killed_while_its_store_was_made_goes_on(recipe, untyped):
    """A kill leaves a folder with a hidden half of a store, which is nothing of anybody's."""
    half = recipe.parent / "mine" / ".sweep.0123abcd.zarr"
    half.mkdir(parents=True)
    (half / "zarr.json").write_text("{")
    assert main(["sweep", str(recipe)]) == 0
    assert {path.name for path in (recipe.parent / "mine").iterdir()} == {"sweep.zarr", "sweep.png"}


def test_the_folder_of_another_sweep_is_refused(recipe, capsys, untyped):
    assert main(["sweep", str(recipe)]) == 0
    recipe.write_text(RECIPE.replace("background = 120", "background = 100"))
    capsys.readouterr()
    assert main(["sweep", str(recipe)]) == 1
    assert "holds another sweep" in capsys.readouterr().err


@pytest.mark.slow
def test_contrast_matters_less_as_speed_rises():
    """What the paper says of its surface: the spread of the peak over contrasts falls from slow edges to fast ones."""
    eye = lgmd.Eye.preset("paper")
    axes = {"contrast": [-0.2, -0.4, -0.6, -0.8, -1.0], "growth_px": [30.0, 60.0, 120.0, 240.0]}
    shown = {"start_radius_px": 0.6, "stop_radius_px": 110.0, "shape": "square", "background": 200.0}
    peak = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **axes, **shown).peak
    spread = (peak.max("contrast") - peak.min("contrast")).values
    assert np.all(np.diff(spread) < 0)
    assert spread[-1] < spread[0] / 5
