"""The text of the C: the numbers of the model, and the mechanisms that it uses alone."""

import dataclasses
import re

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax._c.source import file_names, mechanisms_of, sources
from tests.c.programs import EYE, MODELS, files, vector

PLAIN = "the paper's circuit"


@pytest.mark.parametrize("name", MODELS)
def test_constants_are_the_parameters_that_act_in_single_precision(name):
    model, text = MODELS[name], files(name)["lgmd2.c"]
    constants = dict(re.findall(r"\.(\w+) = (\S+)f, /\*", text))
    assert set(constants) == set(lgmd.symbols()) - model.unused - {"u"}
    for symbol, value in constants.items():
        assert np.float32(value) == np.float32(getattr(model.parameters, symbol)), symbol
        assert lgmd.symbols()[symbol].meaning in text
    persistence = re.findall(r"a\[LGMD2_N_P\] = \{(.+)\};", text)
    expected = [1 / (1 + np.exp(float(model.parameters.u) * i)) for i in range(1, model.n_p + 1)]
    assert [float(each.rstrip("f")) for row in persistence for each in row.split(", ")] == pytest.approx(expected)


# What stands in the code of a mechanism and nowhere else.
TRACES = {
    "size": ("held", "v.tau_hold", "v.A_ffi"),
    "shunt": ("powf", "v.gamma"),
    "lag": ("INFINITY", "LGMD2_PAST"),
    "membrane": ("excitation +=", "tau_cell"),
    "rate": ("REFERENCE_MS / interval_ms",),
    "persistence": ("LGMD2_N_P", "state->oldest"),
    "lamina": ("gone", "v.tau_lamina"),
    "habituation": ("fatigue", "v.tau_hab", "v.S_hab"),
    "exact": ("return -expm1f",),
    "backward_euler": ("(interval + tau)",),
    "gate": ("<= v.T_ffi ?", "<= v.A_ffi ?"),
}


@pytest.mark.parametrize("name", MODELS)
def test_what_a_model_does_not_use_does_not_appear(name):
    model, code = MODELS[name], files(name)["lgmd2.c"] + files(name)["lgmd2.h"]
    present = {*model.mechanisms, model.low_pass}
    present |= {"persistence"} if model.n_p else set()
    present |= set() if "shunt" in model.mechanisms else {"gate"}
    for mechanism, traces in TRACES.items():
        assert any(trace in code for trace in traces) == (mechanism in present), mechanism


def test_a_lag_and_a_membrane_of_nothing_need_no_code():
    model = dataclasses.replace(
        MODELS["all mechanisms"], parameters=dataclasses.replace(MODELS["all mechanisms"].parameters, lag=0, tau_cell=0)
    )
    assert mechanisms_of(model) == ("size", "shunt", "rate")
    assert "past" not in sources(model, vector("all mechanisms"))["lgmd2.c"]


def test_every_equation_is_named():
    text = files(PLAIN)["lgmd2.c"] + files(PLAIN)["lgmd2.h"]
    named = set()
    for first, last in re.findall(r"\b[eE]qs?\.? (\d+)(?:(?:-|, )(\d+))?", text):
        named |= set(range(int(first), int(last or first) + 1))
    assert named == set(range(1, 18))


def test_the_files():
    assert set(files(PLAIN)) == set(file_names())
    assert {"lgmd2.h", "lgmd2.c", "Makefile", "test_lgmd2.c", "test_vector.h"} < set(file_names())
    assert "#define LGMD2_ROWS 12\n" in files(PLAIN)["lgmd2.h"]
    for name, text in files(PLAIN).items():
        assert "{{" not in text.replace("{{0", ""), name
        assert "{%" not in text, name
        assert max(map(len, text.splitlines())) <= 120, name


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"theta2": 1e300}, r"theta2 is 1e\+300, which single precision in C rounds to inf, outside of \[0, inf\)"),
        ({"k": 1e-60}, r"k is 1e-60, which single precision in C rounds to 0, outside of \(0, inf\)"),
        ({"sigma1": 1 - 1e-12}, r"sigma1 is 1, which single precision in C rounds to 1, outside of \[0, 1\)"),
    ],
)
@pytest.mark.filterwarnings("ignore:overflow encountered in cast")
def test_a_parameter_that_leaves_its_domain_is_refused(parameters, message):
    with pytest.raises(ValueError, match=message):
        sources(lgmd.LGMD2(lgmd.Parameters(**parameters), eye=EYE), vector(PLAIN))


def test_a_model_without_an_eye_is_refused():
    with pytest.raises(ValueError, match="the model has no eye, so the size of its frames is not known"):
        sources(lgmd.LGMD2(), vector(PLAIN))
