"""Each condition left out in turn, and predicted by what was fitted to the others."""

import jax
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.fitting._validation import leave_one_out

EYE = lgmd.Eye(rows=8, cols=10, degrees_per_pixel=10.0, fps=30.0)


def mean_of(pairs):
    """In place of a fit: predicts the mean of the curves of these."""
    mean = np.mean([target.values for _, (target,) in pairs], axis=0)

    def predict(stimulus, channel):
        assert channel == "smp_adapted"
        return mean

    return predict


def pairs_of(count):
    values = np.random.default_rng(0).uniform(0.5, 1, (count, 20))
    stimuli = [
        lgmd.Stimulus(jax.numpy.zeros((20, 8, 10)), 30.0, jax.numpy.arange(20.0), name=f"number {i}")
        for i in range(count)
    ]
    return [(shown, [lgmd.Target("smp_adapted", row).on(shown)]) for shown, row in zip(stimuli, values, strict=True)]


def test_what_is_predicted_was_not_seen():
    pairs = pairs_of(3)
    r2 = leave_one_out(mean_of, pairs)
    curves = [target.values for _, (target,) in pairs]
    for i, name in enumerate(("number 0", "number 1", "number 2")):
        others = np.mean([curves[j] for j in range(3) if j != i], axis=0)
        expected = 1 - np.mean((others - curves[i]) ** 2) / np.var(curves[i])
        np.testing.assert_allclose(r2[name], expected)


def test_one_condition_cannot_be_left_out():
    with pytest.raises(ValueError, match="one condition only"):
        leave_one_out(mean_of, pairs_of(1))


def test_a_family_is_left_out_as_one():
    pairs = pairs_of(4)
    r2 = leave_one_out(mean_of, pairs, ["looming", "grating", "looming", "grating"])
    curves = [target.values for _, (target,) in pairs]
    for i, name in enumerate(r2):
        assert name == ("number 0", "number 2", "number 1", "number 3")[i]
    others = np.mean([curves[1], curves[3]], axis=0)
    for i in (0, 2):
        expected = 1 - np.mean((others - curves[i]) ** 2) / np.var(curves[i])
        np.testing.assert_allclose(r2[f"number {i}"], expected)


def test_one_family_cannot_be_left_out():
    with pytest.raises(ValueError, match="one family"):
        leave_one_out(mean_of, pairs_of(3), ["looming"] * 3)
