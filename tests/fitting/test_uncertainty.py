"""Errors and information criteria against lmfit, coverage against simulation, and words against the curves."""

import re
from typing import Any

import jax
import jax.numpy as jnp
import lmfit
import numpy as np
import pytest

from lgmd2jax.fitting._uncertainty.covariance import linearised_uncertainty, prediction_band, sentences

TIME = np.linspace(0, 4, 60)
NAMES = ("a", "b", "c")
SIZE = 10.0  # every parameter lies in [0, 10]
NOISE = 0.05


def decay(values):
    a, b, c = values
    return a * jnp.exp(-b * TIME) + c


def lmfit_of(error=1.0):
    """The fit of lmfit to noisy data, and residuals and Jacobian at its best values."""
    data = np.asarray(decay([2, 1.3, 0.5])) + NOISE * np.random.default_rng(0).normal(size=60)

    def residuals(values):
        return (decay(values) - data) / error

    parameters = lmfit.create_params(a=1, b=1, c=0.1)
    theirs: Any = lmfit.minimize(
        lambda p: np.asarray(residuals(list(p.valuesdict().values()))),
        parameters,
        scale_covar=error == 1.0,
        ftol=1e-14,
        xtol=1e-14,
        gtol=1e-14,
    )
    values = np.array(list(theirs.params.valuesdict().values()))
    return theirs, values, np.asarray(jax.jacfwd(residuals)(jnp.asarray(values))), np.asarray(residuals(values))


def in_box(values, jacobian, residuals, names=NAMES, n_effective=None, absolute=False, priors=0):
    return linearised_uncertainty(
        names,
        values / SIZE,
        lambda z: z * SIZE,
        np.full(len(values), SIZE),
        jacobian * SIZE,
        residuals,
        n_effective=len(residuals) - priors if n_effective is None else n_effective,
        absolute=absolute,
        priors=priors,
    )


@pytest.mark.parametrize("error", [1.0, NOISE])
def test_covariance_and_criteria_of_lmfit(error):
    theirs, values, jacobian, residuals = lmfit_of(error)
    ours = in_box(values, jacobian, residuals, absolute=error != 1.0)
    np.testing.assert_allclose(ours.covariance, theirs.covar, rtol=1e-4)
    np.testing.assert_allclose(ours.standard_errors, [p.stderr for p in theirs.params.values()], rtol=1e-4)
    correlations = [theirs.params["a"].correl["b"], theirs.params["a"].correl["c"], theirs.params["b"].correl["c"]]
    np.testing.assert_allclose(ours.correlation[np.triu_indices(3, 1)], correlations, rtol=1e-4)
    for name, theirs_ in {"chi2": "chisqr", "reduced_chi2": "redchi", "aic": "aic", "bic": "bic"}.items():
        np.testing.assert_allclose(getattr(ours, name), getattr(theirs, theirs_), rtol=1e-8)
    assert (ours.n_effective, ours.degrees_of_freedom, ours.reason) == (60, 57, "")
    assert ours.determined.all()
    slopes = jacobian * error
    band = np.sqrt(np.einsum("ti,ij,tj->t", slopes, theirs.covar, slopes))
    np.testing.assert_allclose(prediction_band(ours, slopes * SIZE), band, rtol=1e-4)


def test_samples_that_repeat_each_other_count_once():
    _, values, jacobian, residuals = lmfit_of()
    once = in_box(values, jacobian, residuals)
    thrice = in_box(
        values, np.repeat(jacobian, 3, 0) / np.sqrt(3), np.repeat(residuals, 3) / np.sqrt(3), n_effective=60
    )
    for name in ("covariance", "intervals", "chi2", "n_effective", "aic", "bic", "degrees_of_freedom", "spectrum"):
        np.testing.assert_allclose(getattr(thrice, name), getattr(once, name), rtol=1e-10)


@pytest.mark.parametrize("absolute", [False, True])
def test_intervals_cover_the_truth_as_often_as_they_say(absolute):
    """A straight line through six points, so few that a normal quantile would cover 88 % with a residual variance."""
    rng, design, truth = np.random.default_rng(1), np.stack([np.ones(6), np.arange(6.0)], axis=1), np.array([5.0, 5.0])
    covered = []
    for _ in range(1000):
        data = design @ truth + rng.normal(size=6)
        values = np.linalg.lstsq(design, data)[0]
        ends = in_box(values, design, design @ values - data, NAMES[:2], absolute=absolute).intervals
        covered.append((ends[:, 0] < truth) & (truth < ends[:, 1]))
    np.testing.assert_allclose(np.mean(covered, axis=0), 0.95, atol=0.02)


def test_a_prior_is_data_with_an_error_of_its_own():
    _, values, jacobian, residuals = lmfit_of()
    ours = in_box(values, np.vstack([jacobian, [[0, 1 / 0.01, 0]]]), np.append(residuals, 0.0), priors=1)
    variance = np.sum(residuals**2) / (60 - 2)
    expected = np.linalg.inv(jacobian.T @ jacobian / variance + np.diag([0, 1 / 0.01**2, 0]))
    np.testing.assert_allclose(ours.covariance, expected, rtol=1e-8)
    assert ours.n_effective == 60
    np.testing.assert_allclose(ours.chi2, np.sum(residuals**2))


def test_a_parameter_without_influence_is_not_determined():
    _, values, jacobian, residuals = lmfit_of()
    three = in_box(values, jacobian, residuals)
    ours = in_box(np.append(values, 0.7), np.hstack([jacobian, np.zeros((60, 1))]), residuals, (*NAMES, "idle"))
    assert ours.determined.tolist() == [True, True, True, False]
    assert ours.standard_errors[3] == np.inf
    np.testing.assert_allclose(ours.intervals[3], [0, SIZE])
    degrees = 57 / 56  # one parameter more
    np.testing.assert_allclose(ours.covariance[:3, :3], three.covariance * degrees, rtol=1e-8)
    assert np.isnan(ours.correlation[3, 0])
    assert "idle has no influence on these curves: any value between its bounds fits as well." in sentences(ours)
    idle = np.array([[0.0, 0, 0, SIZE]])  # a curve on which it has an influence
    np.testing.assert_allclose(prediction_band(ours, idle), SIZE / np.sqrt(12))


def test_parameters_that_replace_each_other_are_not_determined():
    _, values, jacobian, residuals = lmfit_of()
    values, jacobian = np.append(values, 4.0), np.hstack([jacobian, jacobian[:, :1] * values[0] / 4])
    ours = in_box(values, jacobian, residuals, (*NAMES, "d"))  # only a d matters
    assert ours.determined.tolist() == [False, True, True, False]
    assert np.isinf(ours.standard_errors[[0, 3]]).all()
    said = " ".join(sentences(ours))
    assert re.search(r"(a and d|d and a) trade off: raising [ad] by \S+ % and lowering [ad] by \S+ % changes", said)


def test_an_error_wider_than_the_bounds_is_no_determination():
    _, values, jacobian, residuals = lmfit_of()
    ours = in_box(values, jacobian * [1, 1, 1e-3], residuals)
    assert ours.determined.tolist() == [True, True, False]
    np.testing.assert_allclose(ours.intervals[2], [0, SIZE])


def test_a_parameter_on_a_bound_is_held_for_the_others():
    _, values, jacobian, residuals = lmfit_of()
    values = values * [1, 0, 1]
    ours, both = in_box(values, jacobian, residuals), in_box(values[[0, 2]], jacobian[:, [0, 2]], residuals, ("a", "c"))
    assert ours.on_bound.tolist() == [0, -1, 0]
    np.testing.assert_allclose(
        ours.covariance[np.ix_([0, 2], [0, 2])], both.covariance * ours.variance / both.variance, rtol=1e-8
    )
    every = np.linalg.inv(jacobian.T @ jacobian) * ours.variance
    np.testing.assert_allclose(ours.standard_errors[1], np.sqrt(every[1, 1]), rtol=1e-8)
    assert ours.intervals[1, 0] == 0
    assert in_box(np.full(3, SIZE), jacobian, residuals).on_bound.tolist() == [1, 1, 1]


def test_on_a_logarithmic_scale_intervals_are_factors():
    _, values, jacobian, residuals = lmfit_of()
    low, high = 0.01, 100.0
    slopes = values * np.log(high / low)

    def with_slopes(jacobian):
        place = np.log(values / low) / np.log(high / low)
        given = place, lambda z: low * (high / low) ** z, slopes, jacobian * slopes, residuals
        return linearised_uncertainty(NAMES, *given, n_effective=60, absolute=True)

    ours = with_slopes(jacobian)
    np.testing.assert_allclose(ours.values, values)
    np.testing.assert_allclose(ours.intervals[:, 0] * ours.intervals[:, 1], values**2)
    np.testing.assert_allclose(with_slopes(jacobian * 0).intervals, [[low, high]] * 3)


def test_says_why_there_are_no_errors():
    _, values, jacobian, residuals = lmfit_of()
    few = in_box(values, jacobian[:3], residuals[:3])
    assert few.reason == "there are no more independent samples than free parameters"
    broken = in_box(values, jacobian * np.nan, residuals)
    assert broken.reason == "the curves or their slopes are not finite at the best fit"
    idle = in_box(values, jacobian * 0, residuals)
    assert idle.reason == "no parameter is determined by these curves"
    for nothing in (few, broken, idle):
        assert np.isinf(nothing.standard_errors).all()
        assert not nothing.determined.any()
        assert sentences(nothing) == []
    three = [0, 10, 59]  # with known errors as many samples as parameters are enough
    assert in_box(values, jacobian[three], residuals[three] / NOISE, absolute=True).determined.all()


def test_the_words_are_true():
    """Within a short time a slow decay trades its rate for its height; what is named stays within the errors."""
    time = TIME / 40
    truth = np.array([5.0, 5, 3])

    def curve(values):
        return values[0] * jnp.exp(-values[1] * time) + values[2]

    jacobian = np.asarray(jax.jacfwd(curve)(jnp.asarray(truth))) / 0.05
    ours = in_box(truth, jacobian, np.zeros(60), absolute=True)
    said = sentences(ours)
    loose = next(sentence for sentence in said if "trade off" in sentence)
    assert "a" in loose.split(" trade off")[0]

    def chi2_of(sentence):
        changed = truth.copy()
        for way, name, percent in re.findall(r"(raising|lowering) (\w) by (\S+) %", sentence):
            changed[NAMES.index(name)] *= 1 + (0.01 if way == "raising" else -0.01) * float(percent)
        assert (changed != truth).any()
        return float(np.sum((jacobian @ (changed - truth)) ** 2))

    assert chi2_of(loose) < 1.2
    stiff = said[-1]
    (times,) = re.findall(r"changes them by (\S+) times their errors", stiff)
    np.testing.assert_allclose(np.sqrt(chi2_of(stiff)), float(times), rtol=0.2)
