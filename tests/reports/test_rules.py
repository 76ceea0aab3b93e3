"""How samples were counted and errors arose stands in the report of a fit."""

import dataclasses

import jax.numpy as jnp
import numpy as np

import lgmd2jax as lgmd
from lgmd2jax.fitting._conditions import render
from lgmd2jax.fitting._fit import _rules
from lgmd2jax.stimuli import Stimulus
from tests.fitting.fits import curve, fit_with

TIME = np.arange(-40, 41) * 10.0
STIMULUS = Stimulus(jnp.zeros((81, 3, 3)), 100.0, jnp.asarray(TIME))


def test_each_rule_is_told_once_with_the_number_of_curves():
    trains = lgmd.SpikeTrains([[[-30.0, 4.0, 50.0]], [[1.0, 9.0]], [[]]])
    sparse = lgmd.Target("rate", np.zeros(9), np.arange(-400.0, 401, 100.0), interpolate=True)
    plain = lgmd.Target("smp", np.zeros(81))
    pairs = render([(STIMULUS, [trains, plain]), (STIMULUS, [trains, sparse])])
    fit = fit_with(lgmd.Free(k=None).of(lgmd.Parameters), [curve() for _ in range(4)])
    report = " ".join(dataclasses.replace(fit, stats={"rules": _rules(pairs)}).summary().split())
    assert "S.e.m. over 3 animals, drawn towards the Poisson error" in report
    assert "no smaller than the Poisson error (2 of 4 curves)." in report
    assert "A span of 70.9 ms makes one independent sample (2 of 4 curves)." in report
    assert "each is one sample, at the frame nearest to it (1 of 4 curves)." in report
