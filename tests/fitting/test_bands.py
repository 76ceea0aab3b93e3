"""Fits to bands: the residuals by NumPy, no slope within, recovery, and how samples within are counted."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.fitting import Free, Linear
from lgmd2jax.fitting._cell_search import search_cell
from lgmd2jax.fitting._problem import problem_of
from lgmd2jax.fitting._search.points import sobol
from lgmd2jax.fitting._uncertainty.jacobian import sensitivity_at
from lgmd2jax.fitting._validation import leave_one_out

EYE = lgmd.Eye(rows=12, cols=16, degrees_per_pixel=8.0, fps=60.0)
TRUTH = lgmd.LGMD2(lgmd.Parameters(theta2=2.0, T_ffi=25.0, tau2=60.0, k=8.0), N_ts=2)
FREE = Free(theta2=(1, 6), tau3=(100, 1000))
LOOM = lgmd.stimuli.looming(EYE, l_over_v=60.0, contrast=-0.9, start_ms=-900.0, end_ms=300.0)
TRUE_CURVE = np.asarray(TRUTH(LOOM.frames, LOOM.fps).smp_adapted)
COUNT = len(TRUE_CURVE)


def around(half_width: float, error: float = 0.02, quote: str = "") -> lgmd.Target:
    low, high = TRUE_CURVE - half_width, TRUE_CURVE + half_width
    return lgmd.Target("smp_adapted", low, upper=high, error=error, quote=quote)


def problem(target: lgmd.Target, free: Free = FREE):
    return problem_of(TRUTH, lgmd.Observation(), free, [(LOOM, [target.on(LOOM)])], "squares")


def test_residuals_are_the_distance_from_the_nearer_edge():
    low, high = np.random.default_rng(0).uniform(0.5, 0.9, (2, COUNT))
    low, high = np.minimum(low, high), np.maximum(low, high)
    low[::3], high[1::3] = -np.inf, np.inf
    target = lgmd.Target("smp_adapted", low, upper=high, error=0.02, weight=4.0)
    z = jnp.array([0.6, 0.3])
    model = problem(target).at(z, None)[0]
    curve = np.asarray(model(LOOM.frames, LOOM.fps).smp_adapted)
    distance = np.where(curve > high, curve - high, np.where(curve < low, curve - low, 0))
    assert 0.1 < np.mean(distance == 0) < 0.9
    np.testing.assert_allclose(problem(target).residuals(z, None), 2 * distance / 0.02, atol=1e-9)


def test_there_is_no_slope_within_and_that_of_the_curve_outside():
    z, hot = jnp.array([0.6, 0.3]), jnp.asarray(1.0)
    here = sensitivity_at(problem(around(0.03)), z, hot)
    curve, slopes = np.asarray(here.curves[0][0][0]), np.asarray(here.slopes[0][0][0])
    outside = np.abs(curve - TRUE_CURVE) > 0.03
    assert 0 < outside.sum() < COUNT
    np.testing.assert_array_equal(np.asarray(here.jacobian)[~outside], 0)
    np.testing.assert_allclose(np.asarray(here.jacobian)[outside], slopes[outside] / 0.02, rtol=1e-12)


def test_on_an_edge_there_is_no_slope_either():
    """The potential rests at .5 to the last bit, where a band that begins there must not hold it."""
    low = lgmd.Target("smp_adapted", np.full(COUNT, 0.5), upper=np.full(COUNT, 1.0), error=0.02)
    assert np.sum(TRUE_CURVE == 0.5) > 5
    jacobian = jax.jacfwd(lambda z: problem(low).residuals(z, None))(jnp.array([0.6, 0.3]))
    np.testing.assert_array_equal(np.asarray(jacobian), 0)


def test_a_band_without_width_is_a_curve():
    z = jnp.array([0.6, 0.3])
    curve = lgmd.Target("smp_adapted", TRUE_CURVE, error=0.02)
    ours, theirs = (sensitivity_at(problem(target), z, jnp.asarray(1.0)) for target in (around(0.0), curve))
    np.testing.assert_array_equal(ours.residuals, theirs.residuals)
    np.testing.assert_array_equal(ours.jacobian, theirs.jacobian)


@pytest.fixture(scope="module")
def fit():
    """To a narrow band around the response of known parameters."""
    band = around(0.002, error=0.002, quote="rises")
    key = jax.random.key(0)
    return lgmd.fit(TRUTH, [(LOOM, band)], FREE, key=key, pixel_points=8, cell_points=64, descend=2, max_steps=30)


def test_a_narrow_band_gives_the_parameters_back(fit):
    assert fit.values["theta2"] == pytest.approx(2.0, rel=0.03)
    assert fit.curves[0].inside() == 1
    assert fit.curves[0].grade == "good"
    assert np.isnan(fit.curves[0].r2())
    assert fit.loss == 0


def test_samples_within_leave_no_degree_of_freedom(fit):
    curve, u = fit.curves[0], fit.uncertainty
    outside = np.abs(curve.soft - TRUE_CURVE) > 0.002 * (1 + 1e-9)
    assert u.n_effective == COUNT
    assert u.degrees_of_freedom == pytest.approx(outside.sum() - 2)
    chi2 = np.sum(np.square((np.abs(curve.soft - TRUE_CURVE)[outside] - 0.002) / 0.002))
    assert u.chi2 == pytest.approx(chi2, abs=1e-9)
    assert u.aic == pytest.approx(chi2 + 2 * 2)
    assert u.bic == pytest.approx(chi2 + 2 * np.log(COUNT))


def test_the_report_counts_samples_by_band_and_by_words(fit):
    report = fit.summary()
    assert f'"rises": 100.0% of {COUNT} samples within' in report
    assert "Bands (gap" in report
    assert "Curves (gap" not in report
    assert "Bands: a sample within is no difference and leaves no degree of freedom (1 of 1 curves)." in report


def test_a_band_that_is_left_is_remarked():
    high = lgmd.Target("smp_adapted", np.full(COUNT, 0.9), upper=np.full(COUNT, 1.0), error=0.02)
    key = jax.random.key(0)
    settings: Any = {"pixel_points": 2, "cell_points": 8, "descend": 1, "max_steps": 2}
    fit = lgmd.fit(TRUTH, [(LOOM, high)], Free(theta2=(1, 2)), key=key, **settings)
    curve = fit.curves[0]
    assert curve.grade == "missed"
    assert curve.distance().min() == pytest.approx(-0.4)
    remark = (
        f"1 of 1 targets is missed, and a wider search may do better, as 1 of 1 descents ended here: {curve.condition}"
    )
    assert f"{remark} (smp_adapted). The table says by how much." in fit.remarks()


def test_the_best_rate_is_sought_towards_the_band():
    """Baseline and gain of a rate come closer to a band, and are as good as by squares where it has no width."""
    free = Free(theta2=(1, 6), gain=Linear(10, 200), baseline=Linear(0, 20))
    true_rate = np.asarray(lgmd.Observation(5.0, 80.0)(TRUE_CURVE, LOOM.time))
    band = lgmd.Target("rate", true_rate - 2, upper=true_rate + 2, error=1.0)
    z = free.place(TRUTH.parameters, lgmd.Observation(15.0, 30.0))
    best = search_cell(problem(band, free), z, sobol(2, 16, (1,)))
    assert best.loss < 0.05 * best.loss_before


def test_a_band_cannot_be_left_out(fit):
    with pytest.raises(ValueError, match="is a band, which has no R2; leave leave_one_out out"):
        leave_one_out(lambda pairs: fit.predict, [(LOOM, [around(0.1).on(LOOM)])] * 2)
