"""What else a model must do beside its curves: a score chooses among candidates; what acts on nothing is refused."""

import dataclasses

import jax
import numpy as np
import pytest

import lgmd2jax as lgmd

EYE = lgmd.Eye(rows=8, cols=10, degrees_per_pixel=8.0, fps=50.0)
LOOM = lgmd.stimuli.looming(EYE, l_over_v=40.0, contrast=-0.9, start_ms=-400.0, end_ms=100.0)
START, TRUTH = 1.5, 3.0


def model(theta2: float, **structure) -> lgmd.LGMD2:
    return lgmd.LGMD2(lgmd.Parameters(theta2=theta2, k=20.0, T_ffi=60.0), eye=EYE, **structure)


def fit(**settings) -> lgmd.Fit:
    target = lgmd.Target("smp_adapted", np.asarray(model(TRUTH)(LOOM.frames).smp_adapted))
    counts = {"pixel_points": 2, "cell_points": 2, "descend": 1, "temperatures": [0.05]}
    free = lgmd.Free(theta2=(1, 6))
    return lgmd.fit(model(START), [(LOOM, target)], free, key=jax.random.key(0), **counts, **settings)


def test_without_a_score_the_least_loss_decides():
    assert fit().values["theta2"] == pytest.approx(TRUTH, rel=0.05)


@pytest.mark.parametrize("score", [float("nan"), None, "high"])
def test_a_score_that_is_none_is_refused(score):
    with pytest.raises(ValueError, match=r"choose returned .*; let it return a finite number"):
        fit(choose=lambda candidate: score)


def test_the_highest_score_decides_and_of_equals_the_least_loss():
    """The start is the candidate with the smallest theta2; a score that is the same for all leaves the least loss."""
    by_score = fit(choose=lambda candidate: -float(candidate.parameters.theta2))
    assert by_score.values["theta2"] == pytest.approx(START)
    choice = by_score.stats["choice"]
    assert choice["score"] == pytest.approx(-START)
    assert choice["least_loss"] < by_score.loss
    assert "chosen for its score" in by_score.remarks()[0]
    assert by_score.result == "chosen by its score"
    assert by_score.nonlinear == tuple(np.array(by_score.free.names)[by_score.uncertainty.determined])  # no optimum
    indifferent = fit(choose=lambda candidate: 0.0)
    assert indifferent.loss == pytest.approx(indifferent.stats["choice"]["least_loss"])
    assert indifferent.values["theta2"] == pytest.approx(TRUTH, rel=0.05)


@pytest.mark.parametrize(("T_p", "told"), [(5.0, True), (60.0, False)])
def test_noise_that_inhibits_by_itself_is_told(T_p, told):
    """At 50 frames per second noise of 2 grey levels reaches 5 in a step, but never 60."""
    network = model(START, mechanisms=("size",))
    network = dataclasses.replace(network, parameters=dataclasses.replace(network.parameters, T_p=T_p))
    filmed = lgmd.stimuli.camera(LOOM, jax.random.key(0), noise=2.0)
    target = lgmd.Target("smp_adapted", np.asarray(network(filmed.frames).smp_adapted))
    counts = {"pixel_points": 2, "cell_points": 2, "descend": 1, "temperatures": [0.05], "max_steps": 2}
    fit = lgmd.fit(network, [(filmed, target)], lgmd.Free(theta2=(1, 6)), key=jax.random.key(0), **counts)
    remark = next((sentence for sentence in fit.remarks() if "of A_ffi: let T_p rise" in sentence), "")
    assert bool(remark) == told
    assert ("inhibition_in_noise" in fit.stats) == told
    if told:
        share = lgmd.inhibition_in_noise(fit.model, 2.0, 50.0)
        assert f"2 grey levels at 50 frames per second, brings the inhibition to {share:.0%} of A_ffi" in remark


@pytest.mark.parametrize(
    ("free", "structure", "cure"),
    [
        ({"T_p": None}, {}, "T_p is free, but acts on nothing in this LGMD2; add 'size' to its mechanisms"),
        ({"T_ffi": None}, {"mechanisms": ("size",)}, "T_ffi is free, but acts on nothing"),
        ({"u": None}, {}, "u is free, but acts on nothing in this LGMD2; fix the parameter"),
        ({"k": None, "lag": lgmd.Tie("k")}, {}, "lag is free, but acts on nothing"),
    ],
)
def test_what_the_structure_does_not_use_is_not_fitted(free, structure, cure):
    target = lgmd.Target("smp_adapted", np.full(len(LOOM.time), 0.5))
    with pytest.raises(ValueError, match=cure):
        lgmd.fit(model(1.0, **structure), [(LOOM, target)], lgmd.Free(**free), key=jax.random.key(0))
