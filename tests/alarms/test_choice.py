"""The best threshold, against all thresholds on a fine grid."""

import numpy as np
import pytest

from lgmd2jax.alarms._choice import choose

LOW, HIGH = 0.55, 0.95


def cost_at(peaks, wanted, weights, T):
    return float(weights[(peaks >= T) != wanted].sum())


@pytest.mark.parametrize("seed", range(20))
def test_no_threshold_errs_less_and_the_margin_is_half_the_widest_gap_of_that_cost(seed):
    chance = np.random.default_rng(seed)
    peaks, wanted = chance.uniform(0.4, 1, (7, 9)), chance.random(9) < 0.5
    weights = np.where(wanted, 2.0, 0.7)
    choice = choose(peaks, wanted, weights, LOW, HIGH)
    grid = np.linspace(LOW, HIGH, 8001)[1:-1]
    for i, row in enumerate(peaks):
        costs = np.array([cost_at(row, wanted, weights, T) for T in grid])
        assert choice.cost[i] == pytest.approx(costs.min())
        assert cost_at(row, wanted, weights, choice.threshold[i]) == pytest.approx(choice.cost[i])
        good, longest, run = costs <= costs.min() + 1e-9, 0, 0
        edges = np.sort(row)  # where a run of good thresholds crosses a peak, a verdict changes all the same
        for T, is_good, before in zip(grid, good, np.append(LOW, grid[:-1]), strict=True):
            crossed = ((edges > before) & (edges <= T)).any()
            run = (0 if crossed else run) + 1 if is_good else 0
            longest = max(longest, run)
        assert 2 * choice.margin[i] == pytest.approx(longest * (HIGH - LOW) / 8000, abs=2e-4)


def test_candidates_are_ranked_by_cost_then_margin():
    wanted = np.array([True, False])
    peaks = np.array([[0.6, 0.8], [0.8, 0.7], [0.9, 0.6]])
    choice = choose(peaks, wanted, np.ones(2), 0.5, 1.0)
    assert choice.order().tolist() == [2, 1, 0]
    assert choice.cost.tolist() == [1, 0, 0]
    assert choice.threshold[2] == pytest.approx(0.75)
    assert choice.margin[2] == pytest.approx(0.15)


def test_equal_peaks_leave_no_threshold_between_them():
    choice = choose(np.array([[0.7, 0.7]]), np.array([True, False]), np.ones(2), 0.5, 1.0)
    assert choice.cost[0] == 1
    assert abs(choice.threshold[0] - 0.7) == pytest.approx(choice.margin[0])
