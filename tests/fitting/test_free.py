"""What is free: bounds, scales, ties, priors, and their misuse."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.fitting import Free, Linear, Log, Tie

OBSERVATION = lgmd.Observation()


def test_a_point_of_the_box_and_its_values_are_inverse():
    free = Free(theta2=(1, 6), tau1=Log(5, 50), T_sp=None, latency=(0, 100))
    z = np.array([0.3, 0.6, 0.1, 0.9])
    parameters, observation = free.insert(lgmd.Parameters(), OBSERVATION, z)
    np.testing.assert_allclose(free.place(parameters, observation), z, rtol=1e-12)
    np.testing.assert_allclose(parameters.theta2, 1 + 5 * 0.3)
    np.testing.assert_allclose(parameters.tau1, 5 * 10**0.6)
    np.testing.assert_allclose(parameters.T_sp, 0.6 + 0.25 * 0.1)
    np.testing.assert_allclose(observation.latency, 90)
    assert parameters.k == lgmd.Parameters().k


@pytest.mark.parametrize("end", [0.0, 1.0])
def test_the_ends_of_the_box_are_the_bounds(end):
    free = Free(**dict.fromkeys(lgmd.symbols()))
    values = free.values(np.full(len(free), end))
    for name, symbol in lgmd.symbols().items():
        np.testing.assert_allclose(values[name], symbol.bounds[int(end)], rtol=1e-12)


def test_declared_scales_say_what_counts_factors():
    scales = {parameter.name: parameter.scale for parameter in Free(tau1=None, theta2=None, T_s=Linear()).parameters}
    assert scales == {"tau1": "log", "theta2": "linear", "T_s": "linear"}


def test_slopes_are_the_derivatives():
    free = Free(theta2=(1, 6), tau1=Log(5, 50))
    z = np.array([0.3, 0.6])
    slopes = jax.jacfwd(lambda z: jnp.stack(list(free.values(z).values())))(jnp.asarray(z))
    np.testing.assert_allclose(np.diag(slopes), free.slopes(z), rtol=1e-12)


def test_a_tied_parameter_follows():
    parameters = Free(theta2=(1, 6), theta1=Tie("theta2", 0.5)).insert(lgmd.Parameters(), OBSERVATION, np.array([0.4]))[
        0
    ]
    assert parameters.theta1 == 0.5 * parameters.theta2 == 1.5
    to_fixed = Free(k=None, tau2=Tie("tau1")).insert(lgmd.Parameters(tau1=17.0), OBSERVATION, np.array([0.4]))[0]
    assert to_fixed.tau2 == 17


def test_a_prior_is_a_residual_in_its_own_deviations():
    free = Free(tau1=Log(5, 50, prior=(20, 4)), theta2=(1, 6))
    z = np.array([0.5, 0.5])
    np.testing.assert_allclose(free.penalties(z), [(np.sqrt(250) - 20) / 4], rtol=1e-12)
    assert Free(theta2=(1, 6)).penalties(np.array([0.5])).shape == (0,)


def test_equal_choices_are_equal_so_that_nothing_compiles_again():
    one, two = Free(theta2=(1, 6), theta1=Tie("theta2")), Free(theta2=(1, 6), theta1=Tie("theta2"))
    assert one == two
    assert hash(one) == hash(two)
    assert one != Free(theta2=(1, 5), theta1=Tie("theta2"))


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        ({}, "free is empty; name at least one"),
        ({"theta1": Tie("theta2")}, "free is empty"),
        ({"theta4": None}, "free parameter is 'theta4'; choose 'theta"),
        ({"tau1": (20, 10)}, "the first must be below the second"),
        ({"tau1": (-5, 10)}, r"tau1 has the bound -5; it must lie in \(0, inf\)"),
        ({"tau1": (5, np.inf)}, "tau1 has the bound inf"),
        ({"tau1": (5, np.nan)}, "tau1 has the bound nan"),
        ({"tau1": 5}, r"tau1 is 5; give \(low, high\)"),
        ({"theta1": Log()}, "theta1 has the bound 0; bounds on a logarithmic scale"),
        ({"k": None, "theta1": Tie("theta9")}, "theta1 is tied to a parameter that is 'theta9'; choose 'theta"),
        ({"k": None, "theta1": Tie("theta2"), "theta2": Tie("theta3")}, "theta2, which is tied itself"),
        ({"k": None, "theta1": Tie("theta1")}, "theta1, which is tied itself"),
        ({"k": Log(prior=(1, 0))}, "its standard deviation must be positive"),
    ],
)
def test_choices_that_make_no_sense_are_refused(untyped, choices, message):
    with pytest.raises(ValueError, match=message):
        Free(**choices)


def test_a_start_outside_of_its_bounds_is_refused():
    with pytest.raises(ValueError, match="k starts at 1, outside of its bounds 2 to 3"):
        Free(k=(2, 3)).place(lgmd.Parameters(), OBSERVATION)


def test_every_symbol_declares_bounds_within_its_domain():
    for field in dataclasses.fields(lgmd.Parameters):
        symbol = lgmd.symbols()[field.name]
        assert all(symbol.contains(bound) for bound in symbol.bounds)
        assert symbol.scale == "linear" or symbol.bounds[0] > 0
