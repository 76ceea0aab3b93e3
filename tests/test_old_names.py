"""Names of the package that were changed: the old ones work, and name the new ones."""

import pytest

import lgmd2jax as lgmd
from tests.fitting.fits import curve, fit_with


def test_a_network_was_not_called_abstract():
    with pytest.warns(DeprecationWarning, match=r"^lgmd2jax.Network is now lgmd2jax.AbstractNetwork;"):
        assert lgmd.Network is lgmd.AbstractNetwork  # pyright: ignore[reportAttributeAccessIssue]


def test_free_parameters_were_called_freedoms():
    free = lgmd.Free(k=(0.1, 2))
    with pytest.warns(DeprecationWarning, match=r"^Free.freedoms is now Free.parameters;"):
        assert free.freedoms == free.parameters
    assert free.parameters[0].name == "k"


def test_parameters_with_nonlinear_intervals_were_called_curved():
    fit = fit_with(lgmd.Free(k=(0.1, 2)), [curve()], nonlinear=("k",))
    with pytest.warns(DeprecationWarning, match=r"^Fit.curved is now Fit.nonlinear;"):
        assert fit.curved == ("k",)
