"""Each threshold by itself: its rule at ties, its limit, its slope."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd

# For each threshold: its arguments at x, a value of x on the threshold, and a unit step.
CASES = {
    "s": (lambda x: (jnp.full((3, 3), x), jnp.asarray(10.0)), 10.0, 1.0),
    "ffi": (lambda x: (x, jnp.asarray(12.0)), 12.0, 1.0),
    "sfa": (lambda x: (x, jnp.asarray(1e-3)), 1e-3, 1e-3),
    "floor": (lambda x: (x,), 0.5, 0.01),
    "spikes": (lambda x: (x, jnp.asarray(0.75), jnp.asarray(0.125)), 0.75, 0.01),
    "collision": (lambda x: (x, jnp.asarray(6.0)), 6.0, 1.0),
}


def value(thresholds, name, x):
    return jnp.ravel(getattr(thresholds, name)(*CASES[name][0](jnp.asarray(x))))[0]


def test_ties():
    assert value(lgmd.Hard(), "s", 10.0) == 1
    assert value(lgmd.Hard(), "s", np.nextafter(10.0, 0)) == 0
    assert value(lgmd.Hard(), "ffi", 12.0) == 1
    assert value(lgmd.Hard(), "ffi", np.nextafter(12.0, 20)) == 0
    assert value(lgmd.Hard(), "sfa", 1e-3) == 1
    assert value(lgmd.Hard(), "sfa", np.nextafter(1e-3, 1)) == 0
    assert value(lgmd.Hard(), "floor", 0.3) == 0.5
    assert value(lgmd.Hard(), "floor", 0.7) == 0.7
    assert [int(value(lgmd.Hard(), "spikes", x)) for x in (0.7499, 0.75, 0.875, np.nextafter(0.875, 1))] == [0, 1, 1, 2]
    assert [int(value(lgmd.Hard(), "collision", x)) for x in (5.0, 6.0, 7.0)] == [0, 1, 1]


@pytest.mark.parametrize("name", CASES)
def test_cold_soft_is_hard(name):
    _, threshold, step = CASES[name]
    for x in (threshold - step, threshold - 0.51 * step, threshold + 0.51 * step, threshold + step):
        expected = value(lgmd.Hard(), name, x)
        differences = [abs(float(value(lgmd.Soft(t), name, x) - expected)) for t in (1.0, 0.1, 0.01, 0.001)]
        assert differences == sorted(differences, reverse=True)
        assert differences[-1] < 1e-9


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("temperature", [0.1, 1.0])
def test_straight_through_has_the_hard_value_and_the_soft_slope(name, temperature):
    _, threshold, step = CASES[name]
    for x in np.linspace(threshold - 2 * step, threshold + 2 * step, 9):
        for wrt in (jax.grad, jax.jacfwd):
            slope = wrt(lambda x: value(lgmd.StraightThrough(temperature), name, x))(float(x))
            assert slope == wrt(lambda x: value(lgmd.Soft(temperature), name, x))(float(x))
        assert value(lgmd.StraightThrough(temperature), name, x) == value(lgmd.Hard(), name, x)


@pytest.mark.parametrize(
    ("name", "width"), [("s", 1.0), ("ffi", 0.36), ("sfa", 1e-3), ("spikes", 0.01), ("collision", 0.1)]
)
def test_widths_at_temperature_one(name, width):
    """The slope in the middle of a logistic step is 1/(4 width); the second step of spikes adds next to nothing."""
    threshold = CASES[name][1] - (0.5 if name == "collision" else 0)
    slope = jax.grad(lambda x: value(lgmd.Soft(1.0), name, x))(threshold)
    np.testing.assert_allclose(abs(slope), 1 / (4 * width), rtol=1e-4)


def test_widths_follow_their_thresholds():
    narrow, wide = (lgmd.Soft().s(jnp.full((3, 3), 1.1 * T_s), jnp.asarray(T_s))[0, 0] for T_s in (1.0, 30.0))
    np.testing.assert_allclose(narrow, wide, rtol=1e-12)


@pytest.mark.parametrize("temperature", [0, -1.0, np.nan, np.inf])
@pytest.mark.parametrize("kind", [lgmd.Soft, lgmd.StraightThrough])
def test_refuses_a_temperature_that_is_not_positive(kind, temperature):
    with pytest.raises(ValueError, match=r"temperature is .*positive"):
        kind(temperature)
