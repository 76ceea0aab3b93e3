"""A recipe of a fit: other circuits of it, and what is left out of it."""

import dataclasses

import numpy as np
import pytest

import lgmd2jax as lgmd

PROTOCOL = """
[eye]
rows = 6
cols = 8
degrees_per_pixel = 10
fps = 50
[[target]]
law = "rest"
[[condition]]
name = "loom {l_over_v}"
family = "looming"
l_over_v = [20, 40]
contrast = -0.9
start_ms = -300
end_ms = 60
[[condition]]
name = "grating"
family = "grating"
spatial_frequency = 0.02
temporal_frequency = 2
contrast = 1
background = 110
duration_ms = 300
"""
FIT = """
protocol = "protocol.toml"
[free]
k = {}
T_ffi = { low = 2, high = 50 }
[uncertainty]
profile = ["T_ffi"]
[validation]
leave_one_out = "family"
"""


@pytest.fixture
def recipe(tmp_path):
    return load(tmp_path, FIT)


def load(folder, text) -> lgmd.Recipe:
    (folder / "protocol.toml").write_text(PROTOCOL)
    (folder / "fit.toml").write_text(text)
    recipe = lgmd.load_recipe(folder / "fit.toml")
    assert isinstance(recipe, lgmd.Recipe)
    return recipe


def test_another_circuit_frees_what_acts_in_it(recipe):
    other = recipe.with_mechanisms("size", "shunt")
    assert other.model.mechanisms == ("size", "shunt")
    assert set(other.free.names) == {"k", "T_p", "tau_hold", "A_ffi", "m", "gamma"}
    assert other.profile == ()
    assert other.digest() != recipe.digest()
    bounds = {parameter.name: (parameter.low, parameter.high) for parameter in other.free.parameters}
    assert bounds["A_ffi"] == lgmd.symbols()["A_ffi"].bounds


def test_the_table_of_another_circuit_gives_the_same_recipe(recipe, tmp_path):
    other = recipe.with_mechanisms("shunt")
    assert set(other.free.names) == {"k", "T_ffi", "m", "gamma"}
    text = FIT.replace("[free]", '[structure]\nmechanisms = ["shunt"]\n[free]\nm = {}\ngamma = {}')
    by_hand = load(tmp_path, text)
    assert by_hand.model == other.model
    assert set(by_hand.free.parameters) == set(other.free.parameters)


def test_the_plain_circuit_comes_back(recipe):
    again = recipe.with_mechanisms("size", "shunt").with_mechanisms()
    assert again.model == recipe.model
    assert set(again.free.names) == set(recipe.free.names)


def test_a_circuit_that_does_not_exist_is_refused(recipe):
    with pytest.raises(ValueError, match="needs the shunt"):
        recipe.with_mechanisms("membrane")
    other = dataclasses.replace(recipe, model=lgmd.YueRindLGMD1())
    with pytest.raises(ValueError, match="mechanisms belong to an LGMD2"):
        other.with_mechanisms("size")


def test_a_family_is_left_out_as_one(recipe, monkeypatch):
    fits = []

    class Silent:
        result = "converged"

        def predict(self, stimulus, channel):
            return np.full(len(stimulus.time), 0.5)

    def run(self, progress, memory, pairs):
        fits.append([stimulus.name for stimulus, _ in pairs])
        return Silent()

    monkeypatch.setattr(lgmd.Recipe, "run", run)
    assert list(recipe.predict_each()) == ["loom 20", "loom 40", "grating"]
    assert fits == [["grating"], ["loom 20", "loom 40"]]


def test_what_else_is_left_out_is_refused(tmp_path):
    with pytest.raises(ValueError, match="leave_one_out"):
        load(tmp_path, FIT.replace('"family"', '"speed"'))
