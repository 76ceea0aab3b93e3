"""Robust losses against those of scipy."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import least_squares

from lgmd2jax.fitting._robust import LOSSES, robust

R = np.array([-30.0, -2.0, -1.0, -0.3, 0.0, 1e-5, 0.99, 1.01, 7.0])


@pytest.mark.parametrize("loss", LOSSES)
def test_costs_are_those_of_scipy(loss):
    name = "linear" if loss == "squares" else loss
    for r in R:
        cost = least_squares(lambda x, r=r: [r + 0 * x[0]], [0.0], loss=name, max_nfev=1).cost
        np.testing.assert_allclose(0.5 * robust(jnp.array([r]), loss)[0] ** 2, cost, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("loss", LOSSES)
def test_slopes_are_finite_and_signs_stay(loss):
    slopes = jax.vmap(jax.grad(lambda r: robust(r[None], loss)[0]))(jnp.asarray(R))
    assert np.all(np.isfinite(slopes))
    assert np.all(np.asarray(slopes) > 0)
    np.testing.assert_array_equal(np.sign(robust(jnp.asarray(R), loss)), np.sign(R))
