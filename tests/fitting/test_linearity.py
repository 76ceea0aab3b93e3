"""Intervals by linearisation are called rough where chi2 does not rise as they say, and only there."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.fitting._uncertainty.covariance import linearised_uncertainty
from lgmd2jax.fitting._uncertainty.linearity import nonlinear_parameters

FREE = lgmd.Free(theta2=None, tau1=lgmd.Linear(), w_bias=None)
MATRIX = np.random.default_rng(0).normal(size=(60, 3))
NOISE = 1e-3
NOISES = NOISE * np.random.default_rng(1).normal(size=60)
MIDDLE = np.array([0.4, 0.6, 0.5])


def verdict(bent, z=MIDDLE, noise=1.0):
    """The verdict on curves that are linear in a bent version of the point."""

    def residuals(point):
        return MATRIX @ (bent(point) - bent(jnp.asarray(z))) + noise * NOISES

    u = linearised_uncertainty(
        FREE.names,
        z,
        FREE.unpacked,
        FREE.slopes(z),
        np.asarray(jax.jacfwd(residuals)(jnp.asarray(z))),
        np.asarray(residuals(jnp.asarray(z))),
        n_effective=60,
        absolute=False,
    )
    return nonlinear_parameters(residuals, z, u)


def bend(index, curvature):
    def bent(z):
        return z.at[index].add(curvature * jnp.square(z[index] - MIDDLE[index]))

    return bent


def test_linear_curves_are_straight():
    assert verdict(lambda z: z) == ()


@pytest.mark.parametrize("index", range(3))
def test_only_the_parameter_that_bends_is_named(index):
    # Two standard errors are about 2 NOISE / sqrt(60) in the box.
    reach = 2 * NOISE / np.sqrt(60)
    assert verdict(bend(index, 0.05 / reach)) == ()
    assert verdict(bend(index, 1 / reach)) == (FREE.names[index],)


@pytest.mark.parametrize(("curvature", "named"), [(0.15, False), (0.3, True)])
def test_a_known_nonlinearity_is_named_where_chi2_rises_by_half_more(curvature, named):
    """Orthogonal curves in z + c z^2 / (2 s), s the standard error: 2 s away chi2 rises by 4 (1 + c)^2, not by 4."""
    columns = np.linalg.qr(MATRIX)[0]
    noise = NOISES - columns @ (columns.T @ NOISES)  # leaves the optimum where it is
    variance = np.sum(noise**2) / 57
    error = np.sqrt(variance)

    def residuals(point):
        away = point - MIDDLE
        return columns @ away.at[0].add(curvature * away[0] ** 2 / (2 * error)) + noise

    u = linearised_uncertainty(
        FREE.names, MIDDLE, FREE.unpacked, FREE.slopes(MIDDLE), columns, noise, n_effective=60, absolute=False
    )
    np.testing.assert_allclose(np.sqrt(np.diag(u.covariance_z)), error)
    rise = np.sum(np.square(residuals(jnp.asarray(MIDDLE).at[0].add(2 * error)))) - np.sum(noise**2)
    np.testing.assert_allclose(rise / variance, 4 * (1 + curvature) ** 2, rtol=1e-6)
    assert nonlinear_parameters(residuals, MIDDLE, u) == (("theta2",) if named else ())


def test_smaller_noise_straightens_the_same_curves():
    bent = bend(1, np.sqrt(60) / (2 * NOISE))
    assert verdict(bent) == ("tau1",)
    assert verdict(bent, noise=0.01) == ()
    assert verdict(bent, noise=0.0) == ()


def test_at_a_wall_the_other_side_is_judged():
    z = np.array([0.0, 0.6, 0.5])
    assert verdict(lambda point: point, z=z) == ()
    assert verdict(lambda point: point.at[0].add(5e3 * jnp.square(point[0])), z=z) == ("theta2",)


def test_what_is_not_determined_is_not_named_however_it_bends():
    """w_bias has no slope at the best point, and a parabola beside it; tau1 bends too, and is named."""

    def bent(z):
        return z.at[2].set(3 * jnp.square(z[2] - MIDDLE[2]))

    assert verdict(bent) == ()
    assert verdict(lambda z: bend(1, np.sqrt(60) / (2 * NOISE))(bent(z))) == ("tau1",)


@pytest.mark.parametrize("follows", [True, False])
def test_what_moves_along_a_plateau_is_rough_though_it_is_straight_at_the_best_point(follows):
    """Below .4 theta2 leaves no trace of its own, and tau1 makes up for it: locally they are not correlated."""

    def bent(z):
        first = 0.1 * jnp.square(jnp.maximum(z[0] - 0.4, 0))
        return jnp.stack([first, z[1] + follows * 0.2 * jnp.minimum(z[0], 0.4), z[2]])

    names = verdict(bent, z=np.array([0.41, 0.6, 0.5]))
    assert "theta2" in names
    assert ("tau1" in names) == follows


@pytest.mark.parametrize("follows", [True, False])
def test_what_hangs_on_a_parameter_at_its_bound_is_rough(follows):
    """There the others' errors are those with it held; chi2 hardly rises as it leaves the bound."""

    def bent(z):
        return jnp.stack([3e-4 * z[0], z[1] + follows * 0.01 * z[0], z[2]])

    assert verdict(bent, z=np.array([0.0, 0.6, 0.5])) == (("tau1",) if follows else ())
