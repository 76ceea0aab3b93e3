"""The best threshold, against all thresholds on a fine grid."""

import numpy as np
import pytest

from lgmd2jax.alarms._choice import choose

LOW, HIGH, SLACK = 0.55, 0.95, 0.01


def risk_at(row, wanted, weights, T):
    """The logistic share of each event that lies on its wrong side, one by one."""
    scale = min(SLACK, 0.1 * row.std())
    share = [1 / (1 + np.exp((peak - T if hit else T - peak) / scale)) for peak, hit in zip(row, wanted, strict=True)]
    return float(np.dot(weights, share))


@pytest.mark.parametrize("seed", range(10))
def test_no_threshold_is_at_less_risk(seed):
    chance = np.random.default_rng(seed)
    peaks, wanted = chance.uniform(0.4, 1, (7, 9)), chance.random(9) < 0.5
    weights = np.where(wanted, 2.0, 0.7)
    choice = choose(peaks, wanted, weights, LOW, HIGH, SLACK)
    for i, row in enumerate(peaks):
        risks = [risk_at(row, wanted, weights, T) for T in np.linspace(LOW, HIGH, 1001)]
        assert choice.risk[i] <= min(risks) + 2e-3
        assert choice.risk[i] == pytest.approx(risk_at(row, wanted, weights, choice.threshold[i]), abs=1e-4)
        wrong = [(peak >= choice.threshold[i]) != hit for peak, hit in zip(row, wanted, strict=True)]
        assert choice.cost[i] == pytest.approx(np.dot(weights, wrong))
        assert choice.margin[i] == pytest.approx(min(abs(row - choice.threshold[i])))


def test_of_what_is_right_the_widest_margin_is_at_least_risk():
    wanted = np.array([True, False])
    choice = choose(np.array([[0.6, 0.8], [0.8, 0.7], [0.9, 0.6]]), wanted, np.ones(2), 0.5, 1.0, SLACK)
    assert np.argsort(choice.risk).tolist() == [2, 1, 0]
    assert choice.cost.tolist() == [1, 0, 0]
    assert choice.threshold[1:] == pytest.approx([0.75, 0.75], abs=2e-3)
    assert choice.margin[1:] == pytest.approx([0.05, 0.15], abs=2e-3)


@pytest.mark.parametrize("seed", range(5))
def test_evidence_that_lies_close_together_gets_the_same_threshold(seed):
    """A circuit that compresses its evidence is judged as one that does not, once its deviation is below the slack."""
    chance = np.random.default_rng(seed)
    wanted = chance.random(30) < 0.5
    peaks = chance.normal(np.where(wanted, 0.8, 0.7), 0.06)[None]
    wide = choose(peaks, wanted, np.ones(30), LOW, HIGH, SLACK)
    close = choose(peaks / 20, wanted, np.ones(30), LOW / 20, HIGH / 20, SLACK)
    assert close.threshold == pytest.approx(wide.threshold / 20, abs=1e-4)
    assert close.cost == wide.cost


def test_an_event_that_hangs_by_a_hair_counts_for_half():
    """Right on all by a hair, or one plainly wrong and the others safe: near 1 both, and neither is leant on."""
    hits = np.array([True] * 4 + [False] * 4)
    hair = np.array([[0.701, 0.9, 0.9, 0.9, 0.699, 0.5, 0.5, 0.5]])
    safe = np.array([[0.5, 0.9, 0.9, 0.9, 0.5, 0.5, 0.5, 0.5]])
    choices = [choose(peaks, hits, np.ones(8), 0.55, 0.95, SLACK) for peaks in (hair, safe)]
    assert [choice.cost[0] for choice in choices] == [0, 1]
    assert [choice.risk[0] for choice in choices] == pytest.approx([0.95, 1.0], abs=0.05)


def test_weights_move_the_threshold_away_from_what_costs_more():
    peaks, wanted = np.array([[0.8, 0.6]]), np.array([True, False])
    dear_miss, dear_alarm = (
        choose(peaks, wanted, np.array(weights), 0.5, 1.0, SLACK).threshold[0] for weights in ([9.0, 1], [1.0, 9])
    )
    # Exponential tails: nine times the weight is worth slack ln(9)/2 in distance.
    assert dear_alarm - dear_miss == pytest.approx(SLACK * np.log(9), abs=3e-3)
