"""Known parameters come back and hard curves are met: three sets each, twenty as `slow`."""

import pytest

import lgmd2jax as lgmd
from benchmarks.twins import eye_of, stimuli, twin

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
