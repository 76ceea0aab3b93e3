"""Residuals and their correlation in time, against series of known correlation."""

import numpy as np
import pytest

from lgmd2jax.fitting import Free
from lgmd2jax.fitting._residuals import Residuals, residuals_of
from tests.fitting.fits import curve, fit_with


def test_an_autoregressive_series_has_its_known_correlation():
    """Of coefficient a: a^k at lag k, and a span of (1 + a)/(1 - a) samples."""
    noise, a = np.random.default_rng(0).normal(size=200_000), 0.6
    series = np.zeros(len(noise))
    for i in range(1, len(noise)):
        series[i] = a * series[i - 1] + noise[i]
    rest = Residuals(10.0 * np.arange(len(series)), series)
    np.testing.assert_allclose(rest.autocorrelation[:4], a ** np.arange(4), atol=0.01)
    assert rest.correlation_ms == pytest.approx(10 * (1 + a) / (1 - a), rel=0.05)


def test_residuals_are_those_of_the_frames_that_count():
    weight = np.ones(30)
    weight[:10] = 0
    shown = curve(weight=weight)
    rest = residuals_of(shown)
    np.testing.assert_array_equal(rest.time, shown.time[10:])
    np.testing.assert_array_equal(rest.values, (shown.hard - shown.target)[10:])


def test_the_report_names_where_the_model_misses_most():
    hard = curve().hard.copy()
    hard[4] = 2.0
    report = fit_with(Free(theta2=None), [curve(hard=hard)]).summary()
    section = report.split("Residuals of the hard model")[1].split("\n\n")[0]
    (line,) = [line for line in section.splitlines() if "loom" in line]
    assert f"{curve().time[4]:.0f}" in line.split()


def test_residuals_that_do_not_vary_have_no_correlation():
    flat = curve(hard=curve().target)
    assert "nan" not in fit_with(Free(theta2=None), [flat]).summary().split("Residuals of")[1].split("Search")[0]
