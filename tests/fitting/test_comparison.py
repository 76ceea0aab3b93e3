"""Fits side by side: the numbers are those of the curves, and fits to other data are refused."""

import dataclasses
import math
from typing import Any

import jax
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.fitting import Comparison, Fit, Free
from lgmd2jax.fitting._comparison import compared
from lgmd2jax.fitting._uncertainty.covariance import information_criteria
from tests.fitting.fits import curve, fit_with

SMALL, LARGE = Free(theta2=None, tau1=None), Free(theta2=None, tau1=None, gain=None)
SEM = np.full(30, 2.0)


def recorded(seed: int, **changes):
    return curve("recorded", "rate", sem=SEM, error=np.full(30, 3.0), seed=seed, **changes)


def small(*curves) -> Fit:
    return fit_with(SMALL, curves or [recorded(1)])


def large(*curves) -> Fit:
    return fit_with(LARGE, curves or [recorded(2)])


def side_by_side(**fits: Fit) -> Comparison:
    return compared(fits, {})


def test_chi2_and_r2_are_those_of_the_curves_and_add_up():
    of_a, of_b = [curve(seed=1), recorded(1)], [curve(seed=3), recorded(2)]
    found = side_by_side(a=small(*of_a), b=large(*of_b))
    assert found.curves == (("loom", "smp_adapted"), ("recorded", "rate"))
    for chi2, r2, curves in zip(found.chi2, found.r2, (of_a, of_b), strict=True):
        for one, two, each in zip(chi2, r2, curves, strict=True):
            off = each.hard - each.target
            np.testing.assert_allclose(one, np.sum(off**2) / each.error[0] ** 2)
            np.testing.assert_allclose(two, 1 - np.sum(off**2) / np.sum((each.target - each.target.mean()) ** 2))
    to_explain = sum(np.sum((each.target - each.target.mean()) ** 2) / each.error[0] ** 2 for each in of_a)
    np.testing.assert_allclose(found.r2_in_all, 1 - found.chi2.sum(axis=1) / to_explain)
    assert found.free.tolist() == [2, 3]


def test_criteria_are_those_of_thinned_recordings():
    found = side_by_side(a=small(), b=large())
    n = small().uncertainty.n_effective
    assert found.samples == n < 30
    for i, free in enumerate((2, 3)):
        likelihood = n * math.log(found.chi2[i, 0] / n)
        np.testing.assert_allclose(
            [found.aic[i], found.bic[i]], [likelihood + 2 * free, likelihood + free * math.log(n)]
        )


def test_a_built_curve_has_no_criteria():
    found = side_by_side(a=small(curve(), recorded(1)), b=large(curve(), recorded(1)))
    assert np.isnan([*found.aic, *found.bic]).all()
    assert "No AIC and BIC: they are of recordings" in found.summary()


def test_samples_that_are_not_thinned_have_no_criteria():
    def all_independent(fit):
        return dataclasses.replace(fit, uncertainty=dataclasses.replace(fit.uncertainty, n_effective=30.0))

    found = side_by_side(a=all_independent(small()), b=all_independent(large()))
    assert np.isnan(found.bic).all()
    assert "correlation_ms" in found.summary()


def test_criteria_follow_lmfit():
    lmfit = pytest.importorskip("lmfit")
    x = np.linspace(0, 1, 40)
    y = 2 * x + 0.1 * np.random.default_rng(0).normal(size=40)
    model = lmfit.models.LinearModel()
    result = model.fit(y, x=x, slope=1, intercept=0)
    found = information_criteria(result.chisqr, 40, 2)
    np.testing.assert_allclose(found, (result.aic, result.bic))


def test_circuits_with_the_same_answers_are_pointed_out():
    found = side_by_side(a=small(), b=large(), c=large(recorded(1)))
    assert found.alike == (("a", "c"),)
    assert "a and c give the same answers to all of these stimuli" in found.summary()
    assert side_by_side(a=small(), b=large()).alike == ()


def test_parameters_stand_side_by_side_with_what_is_known_of_them():
    a, b = small(), large()
    found = side_by_side(a=a, b=b)
    assert list(found.parameters) == ["theta2", "tau1", "gain"]
    one, other = found.parameters["tau1"]
    assert one is not None
    assert one.value == a.values["tau1"]
    assert one.standard_error == a.uncertainty.standard_errors[1]
    fixed, free = found.parameters["gain"]
    assert fixed == (float(a.observation.gain), 0.0)
    assert str(fixed) == "[100]"
    assert free is not None
    assert other is not None
    assert free.value == b.values["gain"]


def test_what_acts_on_nothing_has_no_value():
    a, b = small(), fit_with(Free(theta2=None, m=None), [recorded(1)])
    b = dataclasses.replace(b, model=dataclasses.replace(b.model, mechanisms=("shunt",)))
    found = side_by_side(a=a, b=b)
    assert found.parameters["m"][0] is None
    assert found.parameters["m"][1] is not None


def test_what_was_left_out_counts_by_what_there_is_to_explain():
    strong, weak = curve("strong"), curve("weak", target=0.5 + 0.1 * curve().target)
    fits = {"a": small(strong, weak), "b": large(strong, weak)}
    found = compared(fits, {"a": {"strong": 0.9, "weak": -3.0}})
    weights = np.var(strong.target), np.var(weak.target)
    expected = (0.9 * weights[0] - 3 * weights[1]) / sum(weights)
    np.testing.assert_allclose(found.left_out_in_mean, np.array([expected, np.nan]))


def test_a_mean_over_some_of_what_was_left_out_is_none():
    """Of a fit that was stopped on the way."""
    names = "one", "other", "flat"
    fits = {name: fit_of(*map(curve, names)) for name, fit_of in (("whole", small), ("stopped", large))}
    left_out = {"whole": {"one": 0.5, "other": 0.3, "flat": np.nan}, "stopped": {"one": 0.9, "flat": np.nan}}
    np.testing.assert_allclose(compared(fits, left_out).left_out_in_mean, [0.4, np.nan])


def test_what_was_not_asked_for_is_not_told():
    text = side_by_side(a=small(), b=large()).summary()
    assert "left out" not in text
    assert "properties" not in text


@pytest.mark.parametrize(
    ("other", "message"),
    [
        ([curve("another", "rate")], "'recorded', rate, is a target of a alone"),
        ([recorded(1), curve()], "'loom', smp_adapted, is a target of b alone"),
        ([recorded(1, target=recorded(1).target + 1e-3)], "target of 'recorded', rate, is another"),
        ([recorded(1, time=recorded(1).time + 5)], "time of 'recorded', rate, is another"),
        ([curve("recorded", "rate", error=SEM)], "error of 'recorded', rate, is another"),
    ],
)
def test_fits_to_other_targets_are_refused(other, message):
    with pytest.raises(ValueError, match=f"a and b are fits to different data: {message}"):
        side_by_side(a=small(), b=large(*other))


def test_fits_to_other_stimuli_are_refused():
    a, b = (dataclasses.replace(small(), stats={"stimuli": {"recorded": digest}}) for digest in ("12", "34"))
    with pytest.raises(ValueError, match="the stimulus of 'recorded' is another"):
        side_by_side(a=a, b=b)


def test_one_fit_has_nothing_beside_it():
    with pytest.raises(ValueError, match="two or more"):
        side_by_side(a=small())


def test_another_contrast_is_another_stimulus_and_chi2_is_that_of_the_fit():
    """A real fit: what its curves add up to is the chi2 of its report."""
    eye = lgmd.Eye(8, 10, 8.0, 60.0)

    def fit_to(contrast):
        looming = lgmd.stimuli.looming(eye, l_over_v=20.0, contrast=contrast, start_ms=-300.0, end_ms=100.0)
        stimulus = dataclasses.replace(looming, name="loom")
        rest = lgmd.Weighted(lgmd.Rest("smp_adapted"), error=0.02, correlation_ms=50, until_ms=50)
        free, model = Free(tau3=(400.0, 1000.0)), lgmd.LGMD2(eye=eye)
        counts: Any = {"pixel_points": 1, "cell_points": 4, "descend": 1, "max_steps": 2}
        return lgmd.fit(model, [(stimulus, rest)], free, key=jax.random.key(0), **counts)

    one, other = fit_to(-0.9), fit_to(-0.5)
    np.testing.assert_allclose(sum(each.chi2("soft") for each in one.curves), one.uncertainty.chi2, rtol=1e-9)
    with pytest.raises(ValueError, match="the stimulus of 'loom' is another"):
        side_by_side(a=one, b=other)
