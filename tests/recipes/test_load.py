"""A recipe by the kind that its file states, read once; targets found on their frames once."""

import contextlib
import tomllib

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.cli import main
from lgmd2jax.fitting._conditions import render

EYE = lgmd.Eye(rows=6, cols=8, degrees_per_pixel=10.0, fps=50.0)
PROTOCOL = """
[eye]
rows = 6
cols = 8
degrees_per_pixel = 10
fps = 50
[[condition]]
name = "loom"
family = "looming"
l_over_v = 20
contrast = -0.9
start_ms = -300
end_ms = 60
[[condition.target]]
law = "rest"
"""
FIT = 'protocol = "protocol.toml"\n[free]\nk = {}\n'
ALARMS = 'kind = "alarms"\nprotocol = "clips.toml"\n[free]\nk = {}\n'
CLIPS = "[eye]\nrows = 6\ncols = 8\ndegrees_per_pixel = 10\nfps = 50\n[rendered]\ncount = 3\n"
SWEEP = 'kind = "sweep"\n[eye]\npreset = "paper"\n[stimulus]\nl_over_v = [10, 20]\ncontrast = -0.9\n'
RECIPES = {"fit": FIT, "named": 'kind = "fit"\n' + FIT, "alarms": ALARMS, "sweep": SWEEP}


@pytest.fixture
def folder(tmp_path):
    for name, text in {**RECIPES, "protocol": PROTOCOL, "clips": CLIPS}.items():
        (tmp_path / f"{name}.toml").write_text(text)
    return tmp_path


@pytest.mark.parametrize(
    ("name", "kind"),
    [("fit", lgmd.Recipe), ("named", lgmd.Recipe), ("alarms", lgmd.alarms.AlarmRecipe), ("sweep", lgmd.SweepRecipe)],
)
def test_the_file_says_which_kind_of_recipe_it_is(folder, name, kind):
    recipe = lgmd.load_recipe(folder / f"{name}.toml")
    assert type(recipe) is kind
    assert recipe.name == name


def test_a_recipe_of_a_sweep_makes_what_sweep_makes(folder):
    (folder / "sweep.toml").write_text(
        SWEEP.replace('preset = "paper"', "rows = 6\ncols = 8\ndegrees_per_pixel = 10\nfps = 50")
    )
    recipe = lgmd.load_recipe(folder / "sweep.toml")
    assert isinstance(recipe, lgmd.SweepRecipe)
    by_hand = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, recipe.eye, l_over_v=[10.0, 20.0], contrast=-0.9)
    assert recipe.run().identical(by_hand)


@pytest.mark.parametrize("kind", ['"sweeps"', "3", "[1]"])
def test_another_kind_is_refused(folder, kind, untyped):
    (folder / "bad.toml").write_text(f"kind = {kind}\n" + FIT)
    with pytest.raises(ValueError, match=r"bad\.toml: kind = .*: choose 'sweep'|bad\.toml: kind = (3|\[1\]): choose '"):
        lgmd.load_recipe(folder / "bad.toml")
    with pytest.raises(ValueError, match="a fit to labelled clips has kind 'alarms'"):
        lgmd.alarms.load_recipe(folder / "fit.toml")


@pytest.mark.parametrize(
    ("command", "recipe", "message"),
    [("fit", "sweep", "is the recipe of a sweep; run lgmd2jax sweep"), ("sweep", "fit", "run lgmd2jax fit")],
)
def test_the_other_command_is_named(folder, command, recipe, message, capsys):
    assert main([command, str(folder / f"{recipe}.toml")]) == 1
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(("command", "name"), [("fit", "fit"), ("stimuli", "protocol"), ("stimuli", "clips")])
def test_a_file_is_read_once(folder, command, name, monkeypatch):
    texts = []
    read = tomllib.loads
    monkeypatch.setattr(tomllib, "loads", lambda text: texts.append(text) or read(text))
    monkeypatch.setattr(lgmd.Recipe, "run", lambda *_, **__: pytest.skip("enough"))
    with contextlib.suppress(pytest.skip.Exception):
        main([command, str(folder / f"{name}.toml"), "-o", str(folder / "results")])
    assert sum(text == (folder / f"{name}.toml").read_text() for text in texts) == 1


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ("leave_one_out", "the target of 'loom' is a band, which has no R2; leave leave_one_out out"),
        ("looming_law", "'loom' is not an approach with a curve in 'rate'"),
    ],
)
def test_what_a_band_cannot_be_asked_is_refused_before_the_fit(folder, choice, message):
    band = 'law = "band"\nlow = 0\nhigh = 9\nchannel = "rate"'
    (folder / "protocol.toml").write_text(PROTOCOL.replace('law = "rest"', band))
    (folder / "fit.toml").write_text(f"{FIT}[validation]\n{choice} = true\n")
    with pytest.raises(ValueError, match=message):
        lgmd.load_recipe(folder / "fit.toml")


@pytest.fixture(scope="module")
def table1():
    recipe = lgmd.load_recipe("table1")
    assert isinstance(recipe, lgmd.Recipe)
    return recipe


def test_table_1_lets_each_sentence_of_the_paper_count_alike(table1):
    weights: dict[tuple[str, str], float] = {}
    for _, targets in table1.pairs:
        for target in targets:
            assert target.is_band
            assert target.quote
            key = target.quote, target.channel
            weights[key] = weights.get(key, 0) + float(target.weight.sum())
    assert len(weights) == 11
    np.testing.assert_allclose(list(weights.values()), 100, rtol=0.015)


def test_table_1_is_fitted_within_the_ranges_of_the_paper(table1):
    ranges = {
        parameter.name: (parameter.low, parameter.high)
        for parameter in table1.free.parameters
        if parameter.name != "w_bias"
    }
    assert ranges == {
        "theta1": (0, 0.1),
        "theta2": (1, 6),
        "theta3": (0, 0.1),
        "tau1": (5, 50),
        "tau2": (5, 100),
        "tau3": (400, 1000),
        "T_sp": (0.65, 0.78),
    }
    assert "w_bias" in table1.free.names
    fixed = {"T_s": 10, "T_ffi": 10, "k": 1, "sigma1": 0.1, "T_sfa": 0.001, "sigma_sp": 0.1}
    assert {name: float(getattr(table1.model.parameters, name)) for name in fixed} == pytest.approx(fixed)


class Counted:
    """A target that counts how often a stimulus asks for it."""

    count = 0

    def on(self, stimulus):
        self.count += 1
        return lgmd.Rest().on(stimulus)


def test_targets_are_found_on_their_frames_once():
    stimulus = lgmd.stimuli.looming(EYE, l_over_v=20.0, contrast=-0.9, start_ms=-300.0, end_ms=60.0)
    target = Counted()
    pairs = render([(stimulus, target), (stimulus, target)])
    assert [pair.stimulus.name for pair in pairs] == ["looming 1", "looming 2"]
    again = render(pairs[1:])
    assert again[0].targets is pairs[1].targets
    assert target.count == 2


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (
            lambda stimulus: [stimulus],
            "condition 1 is of type Stimulus; give a condition, or a stimulus",
        ),
        (lambda stimulus: [(stimulus,)], "condition 1 is of type tuple"),
        (lambda stimulus: [(stimulus, None)], "condition 'looming' has no target"),
        (lambda stimulus: [(stimulus, [])], "condition 'looming' has no target"),
        (lambda stimulus: [(stimulus, np.zeros(3))], "condition 'looming' has a target of type ndarray; give a Target"),
        (lambda stimulus: [(stimulus, ["rest"])], "condition 'looming' has a target of type str; give a Target"),
        (lambda stimulus: [], "conditions is empty"),
        (lambda stimulus: stimulus, "conditions is of type Stimulus; give a list of them"),
        (lambda stimulus: lgmd.Protocol("p", ()), "conditions is a protocol; give its conditions"),
    ],
)
def test_what_is_no_condition_is_refused(wrong, message, untyped):
    stimulus = lgmd.stimuli.looming(EYE, l_over_v=20.0, contrast=-0.9, start_ms=-300.0, end_ms=60.0)
    with pytest.raises(ValueError, match=message):
        render(wrong(stimulus))


@pytest.mark.parametrize(
    ("family", "parameters", "message"),
    [
        ("loming", {}, "family is 'loming'; choose 'looming'"),
        ("looming", {"contrst": -1.0}, "condition 'c': contrst: unknown key; did you mean 'contrast'"),
    ],
)
def test_a_condition_says_at_once_what_is_wrong(family, parameters, message):
    with pytest.raises(ValueError, match=message):
        lgmd.Condition("c", EYE, family, parameters)


def test_a_recipe_names_its_network_and_its_mechanisms(folder):
    (folder / "other.toml").write_text(
        'network = "YueRindLGMD1"\n'
        + FIT.replace("k = {}", "W_I = {}")
        + "[parameters]\nW_I = 0.4\n[structure]\nN_sp = 3\n"
    )
    recipe = lgmd.load_recipe(folder / "other.toml")
    assert isinstance(recipe, lgmd.Recipe)
    assert isinstance(recipe.model, lgmd.YueRindLGMD1)
    assert (float(recipe.model.parameters.W_I), recipe.model.N_sp) == (pytest.approx(0.4), 3)
    (folder / "size.toml").write_text(FIT + '[structure]\nmechanisms = ["size", "shunt"]\n')
    recipe = lgmd.load_recipe(folder / "size.toml")
    assert isinstance(recipe, lgmd.Recipe)
    assert isinstance(recipe.model, lgmd.LGMD2)
    assert recipe.model.mechanisms == ("size", "shunt")
    (folder / "none.toml").write_text('network = "LGMD3"\n' + FIT)
    with pytest.raises(ValueError, match=r"none\.toml: network = 'LGMD3': choose 'LGMD2'"):
        lgmd.load_recipe(folder / "none.toml")
