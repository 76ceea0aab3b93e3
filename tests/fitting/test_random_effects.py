"""Mean and spread over animals against published values and simulations."""

import numpy as np
import pytest

from lgmd2jax.fitting import random_effects

# Log relative risks and variances of 13 trials of the BCG vaccine, Colditz et al. 1994, as in Viechtbauer 2010, whose
# REML estimates are tau^2 = .3132, mean -.7145; I2 by the weights of Higgins and Thompson is 92 %.
RISKS = [
    -0.8893,
    -1.5854,
    -1.3481,
    -1.4416,
    -0.2175,
    -0.7861,
    -1.6209,
    0.0120,
    -0.4694,
    -1.3713,
    -0.3394,
    0.4459,
    -0.0173,
]
VARIANCES = [0.3256, 0.1946, 0.4154, 0.0200, 0.0512, 0.0069, 0.2230, 0.0040, 0.0564, 0.0730, 0.0124, 0.5325, 0.0714]


def test_published_estimates_come_back():
    found = random_effects(np.array(RISKS), np.sqrt(VARIANCES))
    assert found.spread**2 == pytest.approx(0.3132, abs=0.001)
    assert found.mean == pytest.approx(-0.7145, abs=0.001)
    assert found.inconsistency == pytest.approx(0.921, abs=0.002)


def test_equal_errors_have_the_spread_that_their_variance_leaves():
    """With one error s for all, REML is the variance less s^2, and the mean's error that of plain draws."""
    y = np.array([1.0, 2.0, 4.0, 5.5, 3.0])
    found = random_effects(y, np.full(5, 0.5))
    assert found.mean == pytest.approx(y.mean())
    assert found.spread**2 == pytest.approx(np.var(y, ddof=1) - 0.25, rel=1e-5)
    assert found.standard_error == pytest.approx(np.std(y, ddof=1) / np.sqrt(5))
    assert random_effects(y, np.full(5, 3.0)).spread == 0


def test_intervals_hold_the_mean_of_few_animals():
    generator, held, spreads = np.random.default_rng(0), [], []
    for _ in range(400):
        errors = generator.uniform(0.2, 1.5, 8)
        found = random_effects(3 + 0.7 * generator.normal(size=8) + errors * generator.normal(size=8), errors)
        held.append(found.interval[0] <= 3 <= found.interval[1])
        spreads.append(found.spread**2)
    assert 0.92 < np.mean(held) < 0.98
    assert np.mean(spreads) == pytest.approx(0.49, abs=0.1)


def test_misuse_is_refused():
    for estimates, errors in (([1.0], [1.0]), ([1.0, 2.0], [1.0, 0.0]), ([1.0, 2.0], [1.0, np.inf])):
        with pytest.raises(ValueError, match="give two or more, with errors that are positive"):
            random_effects(np.array(estimates), np.array(errors))
