"""Known parameters come back, hard curves are met, intervals cover the truth: one set each, many as `slow`."""

from typing import Any

import numpy as np
import pytest

import lgmd2jax as lgmd
from benchmarks.twins import FREE, SEARCH, WITH_MECHANISMS, coverage, eye_of, stimuli, twin

QUICK: dict[str, Any] = {"pixel_points": 64, "cell_points": 512}


@pytest.fixture(scope="module")
def shown():
    return stimuli(eye_of(4.0))


def soft_twin(seed, shown, **settings: Any):
    result = twin(seed, lgmd.Soft(1.0), shown, **settings)
    assert result.off <= 0.01, f"{result.truth} came back as {result.fit.values}"
    assert result.fit.result == "converged"


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 2))])
def test_soft_twins_come_back(shown, seed):
    soft_twin(seed, shown, **QUICK)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_twenty_soft_twins_come_back(shown, seed):
    soft_twin(seed, shown)


@pytest.mark.parametrize("seed", [2, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 1))])
def test_hard_twins_answer_alike(shown, seed):
    result = twin(seed, lgmd.Hard(), shown, **QUICK)
    assert result.rmse <= 0.01
    assert result.miscounted <= 0.02


@pytest.mark.slow
def test_hard_twins_answer_alike_on_18_of_20_sets(shown):
    twins = [twin(seed, lgmd.Hard(), shown) for seed in range(20)]
    assert sum(result.rmse <= 0.01 and result.miscounted <= 0.02 for result in twins) >= 18


@pytest.mark.slow
def test_hard_twins_with_all_mechanisms_answer_alike_on_18_of_20_sets(shown):
    twins = [twin(seed, lgmd.Hard(), shown, WITH_MECHANISMS) for seed in range(20)]
    assert sum(result.rmse <= 0.01 and result.miscounted <= 0.02 for result in twins) >= 18


@pytest.mark.slow
def test_intervals_cover_the_truth_as_often_as_they_say(shown):
    """200 noisy twins; a share of 95 % lies within 90 to 98 % unless one is unlucky by more than two deviations."""
    fits = [fit for seed in range(200) if (fit := coverage(seed, 0.002, shown, **SEARCH)).valid]
    assert len(fits) >= 190
    held, known = np.array([fit.held for fit in fits]), np.array([fit.known for fit in fits])
    for name, holds, judged in zip(FREE.names, held.T, known.T, strict=True):
        if name == "theta1":  # below the gate it leaves no trace, above it a large one: rarely well determined
            assert holds[judged].mean() >= 0.90
        else:
            assert judged.sum() > 100, name
            assert 0.90 <= holds[judged].mean() <= 0.98, name
