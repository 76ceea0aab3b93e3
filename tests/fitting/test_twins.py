"""Known parameters come back, hard curves are met, intervals cover: three sets each, whole studies as `slow`."""

import numpy as np
import pytest

import lgmd2jax as lgmd
from benchmarks.twins import covered, eye_of, stimuli, twin

QUICK = {"pixel_points": 64, "cell_points": 512}


@pytest.fixture(scope="module")
def shown():
    return stimuli(eye_of(4.0))


def soft_twin(seed, shown, **settings):
    it = twin(seed, lgmd.Soft(1.0), shown, **settings)
    assert it.off <= 0.01, f"{it.truth} came back as {it.fit.values}"
    assert it.fit.result == "converged"


@pytest.mark.parametrize("seed", range(3))
def test_soft_twins_come_back(shown, seed):
    soft_twin(seed, shown, **QUICK)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_twenty_soft_twins_come_back(shown, seed):
    soft_twin(seed, shown)


@pytest.mark.parametrize("seed", range(3))
def test_hard_twins_answer_alike(shown, seed):
    it = twin(seed, lgmd.Hard(), shown, **QUICK)
    assert it.rmse <= 0.01
    assert it.miscounted <= 0.02


@pytest.mark.slow
def test_hard_twins_answer_alike_on_18_of_20_sets(shown):
    twins = [twin(seed, lgmd.Hard(), shown) for seed in range(20)]
    assert sum(it.rmse <= 0.01 and it.miscounted <= 0.02 for it in twins) >= 18


@pytest.mark.slow
def test_intervals_cover_the_truth(shown):
    """200 noisy twins: between 90 and 98 % of the 95 % intervals of each parameter that the curves determine."""
    held, known = covered(shown, 200, 0.02)
    well = known.mean(axis=0) > 0.99
    assert well.sum() >= 4
    assert np.all((held[:, well].mean(axis=0) >= 0.90) & (held[:, well].mean(axis=0) <= 0.98))
