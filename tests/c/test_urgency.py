"""The urgency in the C: what hard.py says, in clean code, and nothing of it where a model has none."""

import numpy as np
import pytest

from lgmd2jax import hard
from lgmd2jax._c.host import compiled
from lgmd2jax._c.memory import memory
from lgmd2jax._c.source import sources
from lgmd2jax._network.structure import structure_of
from tests import clips
from tests.c.programs import EYE, MODELS, files, run, tool, vector, written

LOGISTIC = {
    "within_ms": 400.0,
    "tau_ms": 150.0,
    "intercept": -1.0,
    "smp_adapted": 4.0,
    "level": 2.0,
    "rise": -3.0,
    "inhibition": 1.5,
}
# Two rows that foretell the same, and answers beyond both ends.
TABLE = LOGISTIC | {"predicted": (0.3, 0.35, 0.4, 0.4, 0.55), "observed": (0.05, 0.3, 0.35, 0.6, 0.9)}
CALIBRATIONS = pytest.mark.parametrize("calibration", [LOGISTIC, TABLE], ids=["logistic", "table"])
NAMES = pytest.mark.parametrize("name", ["the paper's circuit", "all mechanisms"])


def texts(name, calibration):
    return sources(MODELS[name], vector(name), calibration)


@NAMES
@CALIBRATIONS
def test_it_says_what_hard_py_says(name, calibration):
    tool("cc")
    model = MODELS[name]
    frames = np.round(clips.loom(1, (60, EYE.rows, EYE.cols))).astype(np.uint8)
    interval = np.random.default_rng(1).choice([2.5, 10.0, 20.0, 60.0], len(frames))
    values = {key: float(value) for key, value in vars(model.parameters).items()}
    oracle = hard.HardLGMD2(values, **structure_of(model), urgency=calibration)
    expected = np.array([oracle.step(f, ms).urgency for f, ms in zip(frames, interval, strict=True)])
    found = compiled(texts(name, calibration), EYE.rows, EYE.cols)(frames, interval).urgency
    np.testing.assert_allclose(found, expected, atol=2e-5)
    assert np.ptp(expected) > 0.2
    if calibration is TABLE:
        assert {0.05, 0.9} & set(expected)
        assert len(set(expected)) >= 5


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@CALIBRATIONS
def test_it_is_clean(calibration, compiler, tmp_path):
    strict = "-O2 -std=c99 -Wall -Wextra -Wconversion -Werror -pedantic -Wshadow -Wdouble-promotion"
    folder = written(tmp_path, texts("all mechanisms", calibration))
    said = run(tool("make"), "-B", "test", f"CC={tool(compiler)}", f"CFLAGS={strict}", folder=folder)
    assert said.endswith("test vector: 24 frames of 8 x 10 came out\n")
    checks = ("--std=c99", "--enable=warning,style,performance,portability", "--error-exitcode=1", "--quiet")
    assert run(tool("cppcheck"), *checks, "lgmd2.c", "test_lgmd2.c", folder=folder) == ""
    assert max(len(line) for text in texts("all mechanisms", calibration).values() for line in text.splitlines()) <= 120


@NAMES
def test_its_average_is_part_of_the_state(name, tmp_path):
    program = '#include <stdio.h>\n#include "lgmd2.h"\nint main(void) { printf("%d", (int)sizeof(lgmd2_state)); }\n'
    folder = written(tmp_path, texts(name, LOGISTIC) | {"size.c": program})
    run(tool("gcc"), "-std=c99", "size.c", "-o", "size", folder=folder)
    assert int(run("./size", folder=folder)) == memory(MODELS[name], EYE.rows, EYE.cols, urgency=True).state


def test_without_a_calibration_it_is_not_a_number():
    tool("cc")
    name = "the paper's circuit"
    frames = clips.noise(0, (5, EYE.rows, EYE.cols)).astype(np.uint8)
    response = compiled(files(name), EYE.rows, EYE.cols)(frames, np.full(5, 20.0))
    assert np.isnan(response.urgency).all()
    assert "state->level" not in files(name)["lgmd2.c"]


def test_weights_beyond_single_precision_are_refused():
    name = "the paper's circuit"
    with pytest.raises(ValueError, match=r"rise of the urgency is 1e\+300, which single precision cannot hold"):
        sources(MODELS[name], vector(name), LOGISTIC | {"rise": 1e300})
