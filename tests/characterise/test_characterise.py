"""The exam for its users: what is refused, what is not judged, the table, JSON, the figure; once all of it."""

import dataclasses
import json
import logging
import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from matplotlib.image import imread

import lgmd2jax as lgmd
from lgmd2jax._characterise import trials
from lgmd2jax._characterise.characterise import _neuron, differences
from lgmd2jax._characterise.measurements import result_of, unjudged
from lgmd2jax._characterise.result import Characterisation, number, table
from lgmd2jax._characterise.selectivity import UNITS, intervals, selectivity
from lgmd2jax._figures.characterise import characterisation_figure
from tests.characterise.signals import EXAM, EYE, curves, eta, examine, ideal, onset
from tests.fitting.fits import fit_with

SMALL = lgmd.Eye(rows=12, cols=16, degrees_per_pixel=8.0, fps=100.0)
MODEL = lgmd.LGMD2(lgmd.Parameters(T_s=3.0, T_ffi=3.0, T_sfa=3e-4, k=0.3, sigma1=0.5), eye=SMALL)


@pytest.fixture(scope="module")
def results() -> dict[str, Characterisation]:
    """An ideal neuron and one that answers light looms and halved light otherwise."""
    other = ideal() | {trials.LIGHT_LOOM: eta(40.0, 0.5), trials.HALVED: eta(40.0, 0.7)}
    return {"ideal": result_of(EXAM, "LGMD2", examine(ideal())), "other": result_of(EXAM, "LGMD2", examine(other))}


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (lgmd.LGMD2(), "no eye"),
        (lgmd.LGMD2(eye=lgmd.Eye.preset("paper")), "has no degrees_per_pixel"),
        (lgmd.LGMD2(eye=dataclasses.replace(EYE, fps=5.0)), "fps is 5"),
        (lgmd.LGMD2(eye=dataclasses.replace(EYE, rows=10)), "20 x 128 degrees"),
        (lgmd.LGMD2(eye=dataclasses.replace(EYE, degrees_per_pixel=12.0)), "12 degrees a pixel"),
    ],
)
def test_what_cannot_be_shown_is_refused(model, message):
    for exam in (lgmd.characterise, lgmd.ablations, lgmd.rasters):
        with pytest.raises(ValueError, match=message):
            exam(model)


def test_misuse_is_refused(untyped):
    name: Any = "lgmd2"
    with pytest.raises(ValueError, match="give a model, such as"):
        lgmd.characterise(name)
    with pytest.raises(ValueError, match="model is no fit"):
        lgmd.characterise(MODEL, key=jax.random.key(0))
    batch = jax.vmap(lambda theta: lgmd.Parameters(theta1=theta))(jnp.zeros(3))
    with pytest.raises(ValueError, match="theta1 has shape"):
        lgmd.characterise(lgmd.LGMD2(batch, eye=EYE))


def test_a_circuit_whose_on_pathway_counts_is_no_lgmd2():
    neurons = [_neuron(lgmd.LGMD2(lgmd.preset(name))) for name in ("lgmd2", "balanced", "light_selective")]
    assert neurons == ["LGMD2", "LGMD1", "LGMD1"]
    assert _neuron(lgmd.LGMD2(lgmd.Parameters(theta1=0.4))) == "LGMD2"


def test_rows_that_are_not_judged_say_why():
    assert unjudged(EYE, "LGMD2") == {}
    assert unjudged(EYE, "LGMD1") == dict.fromkeys((9, 10, 11, 12), "not meant")
    assert unjudged(dataclasses.replace(EYE, fps=99.0), "LGMD2") == dict.fromkeys((1, 2, 3, 4, 5, 22), "undersampled")
    assert unjudged(dataclasses.replace(EYE, cols=39), "LGMD2") == dict.fromkeys((12, 13, 15), "beyond field")
    balanced = result_of(EXAM, "LGMD1", examine(ideal()))
    assert (balanced.passed, balanced.judged) == (18, 18)
    assert balanced[9].passed is None
    assert balanced[9].verdict == "not meant"


def test_the_result_holds_what_was_measured(results):
    ideal_one, other = results.values()
    assert (ideal_one.passed, ideal_one.judged) == (22, 22)
    assert [row.number for row in other.rows if not row.passed] == [9, 19]
    assert other[19].name == "all luminances halved"
    assert other[19].values[0] == pytest.approx(-30, abs=0.5)
    assert ideal_one.reference == pytest.approx(0.4, abs=0.002)
    assert ideal_one.panels["peak R, deviation"] == pytest.approx(np.exp(-np.array(trials.DEVIATIONS) / 15), abs=2e-3)
    time, r = ideal_one.curves[trials.REFERENCE]
    assert time.shape == r.shape
    assert r.max() == pytest.approx(1)


def test_selectivity_of_known_curves():
    names = (
        *(trials.loom(speed) for speed in trials.L_OVER_V),
        trials.LIGHT_LOOM,
        trials.RECESSION,
        trials.translation(),
    )
    neuron = {name: eta(speed) for name, speed in zip(names, trials.L_OVER_V, strict=False)}
    neuron |= {trials.LIGHT_LOOM: eta(40.0, 0.25), trials.RECESSION: onset(0.2, 40.0), names[-1]: onset(0.5, 90.0)}
    values = {name: float(value) for name, value in jax.jit(selectivity)(curves(neuron, *names)).items()}
    assert set(values) == set(UNITS)
    assert values["dark/light index"] == pytest.approx(0.75 / 1.25, abs=0.01)
    assert values["looming/translation ratio"] == pytest.approx(2, abs=0.01)
    assert values["alpha"] == pytest.approx(4.4, abs=0.02)
    assert values["threshold angle"] == pytest.approx(2 * math.degrees(math.atan(1 / 4.4)), abs=0.1)
    # The integral of eta over its peak: the angle's own, (1 - exp(-alpha pi))/alpha, by the peak of that.
    best = 2 * math.atan(1 / 4.4)
    area = 1 / 4.4 / (2 / 40 * math.sin(best / 2) ** 2 * math.exp(-4.4 * best))
    assert values["approach/recession index"] == pytest.approx((area - 8) / (area + 8), abs=0.02)


def test_differences_name_verdicts_and_the_shift_of_alpha(results):
    shifted = dataclasses.replace(results["other"], selectivity=dict(results["other"].selectivity))
    alpha = shifted.selectivity["alpha"]
    shifted.selectivity["alpha"] = alpha._replace(value=alpha.value + 0.5)
    same, changed = differences({"as it is": results["ideal"], "same": results["ideal"], "moved": shifted})
    assert same == "same: alpha shifts by +0.00; verdicts that change: none"
    assert "moved: alpha shifts by +0.50" in changed
    assert "9 light looms are weak (pass -> FAIL), 19 all luminances halved (pass -> FAIL)" in changed


def test_the_table_has_a_line_for_every_value_and_a_column_for_every_model(results):
    text = table(results)
    lines = text.splitlines()
    assert max(map(len, lines[:-1])) <= 110
    for row in results["ideal"].rows:
        assert sum(line.startswith(f"{row.number:2} {row.name}") for line in lines) == 1
        for line in row.row.lines:
            assert any(line.label in text_line and line.bound in text_line for text_line in lines)
    assert "22 of 22" in text
    assert "20 of 22" in text
    (light,) = (line for line in lines if line.startswith(" 9 "))
    assert light.split()[-2:] == ["pass", "FAIL"]
    assert "[A]" in next(line for line in lines if "delta" in line)
    assert results["ideal"].summary() == table({"value": results["ideal"]})


@pytest.mark.parametrize(
    ("value", "text"), [(math.nan, "-"), (math.inf, "inf"), (0.12345, "0.123"), (-1e-9, "0"), (-25.17, "-25.2")]
)
def test_numbers(value, text):
    assert number(value) == text


def test_json_holds_no_infinite_numbers(results):
    silent = result_of(EXAM, "LGMD2", examine(ideal(), gain=0.01))
    text = json.dumps([result.plain() for result in (*results.values(), silent)], allow_nan=False)
    content = json.loads(text)
    assert [result["passed"] for result in content] == [22, 20, 0]
    row = content[0]["rows"][1]
    assert row["name"] == "slope and delay of that line"
    assert row["lines"][0]["low"] == 2.75
    assert row["lines"][0]["evidence"] == "A"
    assert content[2]["rows"][1]["lines"][0]["value"] is None


def test_the_figure(results, tmp_path):
    models = {**results, "silent": result_of(EXAM, "LGMD2", examine(ideal(), gain=0.01))}
    characterisation_figure(tmp_path / "a.png", models)
    picture = imread(tmp_path / "a.png")
    assert min(picture.shape[:2]) > 1000
    with pytest.raises(ValueError, match="at most 7"):
        characterisation_figure(tmp_path / "b.png", {str(number): results["ideal"] for number in range(8)})
    assert not (tmp_path / "b.png").exists()


@pytest.mark.slow
def test_a_second_model_compiles_nothing_anew(caplog):
    """The whole exam by a small eye; ablations and other values are the same programs."""
    lgmd.characterise(lgmd.ablate(MODEL, "ffi"))
    other = dataclasses.replace(MODEL, parameters=dataclasses.replace(MODEL.parameters, tau2=300.0, theta1=0.2))
    with jax.log_compiles(), caplog.at_level(logging.WARNING):
        second = lgmd.characterise(other)
        variants = lgmd.ablations(other)
    assert not [text for text in caplog.messages if "Finished XLA compilation" in text]
    assert list(variants) == ["intact", "without ffi", "without sfa", "without lateral", "without on", "without off"]
    for a, b in zip(second.rows, variants["intact"].rows, strict=True):
        np.testing.assert_array_equal(a.values, b.values)
    assert variants["without sfa"][14].values[0] == pytest.approx(1)
    # What FFI is for: a large step of the whole field, third line of the row.
    assert [variants[name][17].values[2] for name in ("intact", "without ffi")] == pytest.approx([0, 1], abs=0.01)


@pytest.mark.slow
def test_intervals_hold_the_value_and_come_from_the_key():
    fit = fit_with(lgmd.Free(tau2=lgmd.Log(20, 300), T_ffi=lgmd.Log(1, 10)), [])
    fit = dataclasses.replace(fit, model=dataclasses.replace(fit.model, eye=SMALL))
    first, again, other = (intervals(fit, SMALL, jax.random.key(seed), draws=8) for seed in (0, 0, 1))
    assert list(first) == list(UNITS)
    assert first == again
    assert first != other
    low, high = first["alpha"]
    assert low < high
