"""Profile-likelihood intervals against MINOS."""

from typing import Any

import iminuit
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from lgmd2jax.fitting._uncertainty.covariance import linearised_uncertainty
from lgmd2jax.fitting._uncertainty.profile import profile_likelihood, rise_limit

TIME = np.linspace(0, 2, 12)
NOISE = 0.15
LIMIT = float(stats.chi2.ppf(0.95, 1))
HIGH = np.array([10.0, 5, 4])  # the box is [0, HIGH]
TRACES = []


def residuals(z):
    """A decay that is so noisy and so short that its intervals are far from symmetric, in standard errors."""
    TRACES.append(z)
    a, b, c = z * HIGH
    data = 2 * np.exp(-1.3 * TIME) + 0.5 + NOISE * np.random.default_rng(5).normal(size=12)
    return (a * jnp.exp(-b * TIME) + c - data) / NOISE


@pytest.fixture(scope="module")
def minimum():
    value = jax.jit(lambda z: jnp.sum(residuals(z) ** 2))
    new: Any = iminuit.Minuit
    minuit = new(lambda z: float(value(z)), np.array([0.2, 0.25, 0.1]), grad=jax.jit(jax.grad(value)))
    minuit.errordef = iminuit.Minuit.LEAST_SQUARES
    minuit.limits = [(0, 1)] * 3
    minuit.strategy, minuit.tol = 2, 1e-6
    minuit.migrad()
    minuit.minos(cl=0.95)
    assert minuit.valid
    return minuit


@pytest.mark.parametrize("index", range(3))
def test_the_interval_of_minos(minimum, index):
    ours = profile_likelihood(
        residuals,
        np.array(minimum.values),
        index,
        variance=1.0,
        limit=LIMIT,
        step=0.05,
        value=lambda z: float(z * HIGH[index]),
    )
    theirs, best = minimum.merrors[index], minimum.values[index]
    assert theirs.is_valid
    assert ours.is_open == (theirs.at_lower_limit, theirs.at_upper_limit) == (index == 2, False)
    width = theirs.upper - theirs.lower
    expected = [0 if index == 2 else best + theirs.lower, best + theirs.upper]
    np.testing.assert_allclose(np.array(ours.interval) / HIGH[index], expected, atol=2e-3 * width)
    assert abs(theirs.upper + theirs.lower) > 0.02 * width, "the problem must not be symmetric"
    np.testing.assert_allclose(ours.rise[ours.values == ours.interval[1]], LIMIT, rtol=5e-3)
    assert (np.diff(ours.values) > 0).all()
    assert len(ours.values) < 20


def test_starts_from_its_own_minimum(minimum):
    """A point that is a little off must not shift the interval."""
    z = np.array(minimum.values)
    exact, off = (
        profile_likelihood(residuals, start, 0, variance=1.0, limit=LIMIT, step=0.05) for start in (z, z * 1.2)
    )
    np.testing.assert_allclose(off.interval, exact.interval, rtol=1e-3)


def test_a_larger_variance_widens_the_interval_as_its_root(minimum):
    z = np.array(minimum.values)
    narrow = profile_likelihood(residuals, z, 0, variance=1e-4, limit=LIMIT, step=1e-3)  # so narrow that it is linear
    wide = profile_likelihood(residuals, z, 0, variance=4e-4, limit=LIMIT, step=1e-3)
    np.testing.assert_allclose(np.diff(wide.interval), 2 * np.diff(narrow.interval), rtol=1e-2)


def test_an_end_beyond_the_box_is_open():
    def flat(z):
        return jnp.stack([4 * (z[0] - 0.3), 1e-3 * z[1] + z[0] - 0.3])

    idle = profile_likelihood(flat, np.array([0.3, 0.5]), 1, variance=1.0, limit=LIMIT, step=0.25)
    assert (idle.is_open, idle.interval) == ((True, True), (0.0, 1.0))
    near = profile_likelihood(flat, np.array([0.3, 0.5]), 0, variance=1.0, limit=LIMIT, step=0.1)
    assert near.is_open == (True, False)
    np.testing.assert_allclose(near.interval, np.array([0, 0.3 + np.sqrt(LIMIT / 17)]), rtol=1e-3)


@pytest.mark.parametrize(("absolute", "law"), [(True, stats.norm), (False, stats.t(5))])
def test_of_linear_curves_the_interval_is_that_of_the_covariance(absolute, law):
    """Errors of scale unknown leave 5 degrees of freedom here, with which the interval is wider by a third."""
    chance = np.random.default_rng(3)
    jacobian = 40 * chance.normal(size=(7, 2))
    noise = chance.normal(size=7)
    noise -= jacobian @ np.linalg.lstsq(jacobian, noise)[0]
    z = np.array([0.4, 0.6])
    u = linearised_uncertainty(
        ("a", "b"), z, lambda z: z, np.ones(2), jacobian, noise, n_effective=7, absolute=absolute
    )
    error = np.sqrt(np.linalg.inv(jacobian.T @ jacobian)[0, 0] * (1 if absolute else noise @ noise / 5))
    for confidence in (0.95, 0.68):
        limit = rise_limit(u, confidence)
        ours = profile_likelihood(
            lambda point: jnp.asarray(jacobian) @ (point - z) + noise, z, 0, variance=u.variance, limit=limit, step=0.05
        )
        reach = law.ppf(0.5 + confidence / 2) * error
        np.testing.assert_allclose(ours.interval, [0.4 - reach, 0.4 + reach], atol=2e-3 * reach)


def test_compiles_once_for_all_parameters(minimum):
    z = np.array(minimum.values)
    profile_likelihood(residuals, z, 0, variance=1.0, limit=LIMIT, step=0.05)
    before = len(TRACES)
    for index in (1, 2):
        profile_likelihood(residuals, z, index, variance=1.0, limit=LIMIT, step=0.05)
    assert len(TRACES) == before
