"""The score test against least squares with the parameter free, which linear curves make exact."""

import numpy as np
import pytest
import scipy

from lgmd2jax.fitting._uncertainty.score import promises

NOISE = np.random.default_rng(0)
ALL = NOISE.normal(size=(60, 5))
DATA = ALL @ [1.0, -0.5, 0.3, 0.0, 0.2] + 0.05 * NOISE.normal(size=60)


def scores(held=(False, False), bounds=(-10.0, 10.0)):
    """Two parameters are free and fitted, three are fixed at 0."""
    free = ALL[:, :2]
    best = np.linalg.lstsq(free, DATA, rcond=None)[0]
    return promises(
        free @ best - DATA,
        free,
        ALL[:, 2:],
        names=("a", "b", "c"),
        values=np.zeros(3),
        bounds=np.tile(bounds, (3, 1)),
        held=np.array(held),
    )


def chi2(columns):
    return float(np.linalg.lstsq(ALL[:, columns], DATA, rcond=None)[1][0])


def test_what_is_promised_is_what_a_fit_with_it_free_gains():
    for score in scores():
        i = 2 + "abc".index(score.name)
        assert score.decrease == pytest.approx(chi2([0, 1]) - chi2([0, 1, i]), rel=1e-9)
        assert score.better == pytest.approx(np.linalg.lstsq(ALL[:, [0, 1, i]], DATA, rcond=None)[0][2], rel=1e-9)
        assert score.probability == pytest.approx(scipy.stats.chi2.sf(score.decrease, 1))
    assert [score.name for score in scores()][:2] == ["a", "c"]


def test_a_step_ends_at_a_bound_and_promises_less():
    whole, cut = ({score.name: score for score in scores(bounds=(-10.0, high))} for high in (10.0, 0.1))
    assert cut["a"].better == 0.1
    assert 0 < cut["a"].decrease < whole["a"].decrease
    none = {score.name: score for score in scores(bounds=(-10.0, 0.0))}
    assert (none["a"].better, none["a"].decrease, none["a"].probability) == (0.0, 0.0, 1.0)


def test_what_a_free_parameter_can_replace_is_left_out():
    free = ALL[:, :2]
    twice = np.stack([2 * free[:, 0] - free[:, 1], np.zeros(60)], axis=1)
    settings = {"names": ("d", "e"), "values": np.zeros(2), "bounds": np.tile([-1.0, 1.0], (2, 1))}
    assert promises(DATA, free, twice, held=np.array([False, False]), **settings) == []
    assert [score.name for score in promises(DATA, free, twice, held=np.array([True, False]), **settings)] == ["d"]
