"""The whole fit: recovery, repetition, stopping, other solvers, degenerate cases, misuse; all small."""

from typing import Any

import jax
import numpy as np
import optimistix as optx
import pytest

import lgmd2jax as lgmd
from lgmd2jax._channels import Channel
from lgmd2jax.fitting import _problem
from lgmd2jax.fitting._search import search as _search

EYE = lgmd.Eye(rows=12, cols=16, degrees_per_pixel=8.0, fps=60.0)
OBSERVATION = lgmd.Observation(baseline=5.0, gain=80.0, latency=30.0)
FIXED: dict[str, Any] = {"T_s": 5.0, "T_sfa": 5e-4, "tau2": 300.0, "T_ffi": 12.0}
TRUTH: dict[str, Any] = {"theta2": 1.5, "k": 0.4, "tau3": 250.0}
FREE = lgmd.Free(theta2=(1, 6), k=(0.1, 2), tau3=lgmd.Log(100, 1000))
QUICK: dict[str, Any] = {"pixel_points": 8, "cell_points": 64, "descend": 2}
KEY = jax.random.key(1)


@pytest.fixture(scope="module")
def looms():
    return [
        lgmd.stimuli.looming(EYE, l_over_v=l_over_v, contrast=-0.9, start_ms=-600.0, end_ms=200.0)
        for l_over_v in (20.0, 40.0)
    ]


def conditions(looms, model, channel: Channel = "smp_adapted", **settings):
    return [(stimulus, lgmd.ModelTarget(model=model, channel=channel, **settings)) for stimulus in looms]


def model_of(thresholds, **parameters):
    return lgmd.LGMD2(lgmd.Parameters(**FIXED, **parameters), thresholds, eye=EYE)


@pytest.fixture(scope="module")
def soft_fit(looms):
    soft = lgmd.Soft(1.0)
    return lgmd.fit(model_of(soft), conditions(looms, model_of(soft, **TRUTH)), FREE, key=KEY, **QUICK)


def test_a_soft_model_comes_back(soft_fit):
    for name, value in TRUTH.items():
        np.testing.assert_allclose(soft_fit.values[name], value, rtol=1e-5)
    assert soft_fit.result == "converged"
    assert soft_fit.temperatures == (1.0,)
    assert isinstance(soft_fit.model.thresholds, lgmd.Soft)
    assert soft_fit.parameters.T_ffi == FIXED["T_ffi"]
    assert soft_fit.start == {"theta2": 1.0, "k": 1.0, "tau3": pytest.approx(500)}
    assert soft_fit.model.eye == EYE
    assert all(curve.r2("soft") > 1 - 1e-9 for curve in soft_fit.curves)


def test_small_weights_do_not_end_a_descent_early(looms):
    """Weights count by their ratios alone."""
    start = model_of(lgmd.Soft(1.0), theta2=2.0, k=0.6, tau3=400.0)
    settings: dict[str, Any] = {**QUICK, "pixel_points": 1, "cell_points": 1, "descend": 1}
    pairs = conditions(looms, model_of(lgmd.Soft(1.0), **TRUTH))
    light = [(stimulus, lgmd.Weighted(target, weight=1e-14)) for stimulus, target in pairs]
    fit = lgmd.fit(start, light, FREE, key=KEY, **settings)
    for name, value in TRUTH.items():
        np.testing.assert_allclose(fit.values[name], value, rtol=1e-5)


def test_stimuli_of_one_family_keep_names_of_their_own(soft_fit):
    assert [curve.condition for curve in soft_fit.curves] == ["looming 1", "looming 2"]


def test_a_hard_model_is_handed_over(looms):
    truth = model_of(lgmd.Hard(), **TRUTH)
    fit = lgmd.fit(model_of(lgmd.Hard()), conditions(looms, truth), FREE, key=KEY, **QUICK)
    assert isinstance(fit.model.thresholds, lgmd.Hard)
    assert all(curve.rmse("hard") < 2e-3 for curve in fit.curves)
    assert all(run.loss <= run.start_loss for run in fit.runs)
    losses = [run.loss for run in fit.runs]
    assert losses == sorted(losses)
    np.testing.assert_allclose(fit.loss, 0.5 * sum(np.sum((c.hard - c.target) ** 2) for c in fit.curves), rtol=1e-9)
    np.testing.assert_allclose(
        fit.soft_loss, 0.5 * sum(np.sum((c.soft - c.target) ** 2) for c in fit.curves), rtol=1e-9
    )
    predicted = fit.predict(looms[0])
    np.testing.assert_allclose(predicted, truth(looms[0].frames, 60.0).smp_adapted, atol=0.01)
    np.testing.assert_allclose(fit.curves[0].hard, predicted, atol=1e-9)


def test_a_rate_with_its_observation(looms):
    truth = model_of(lgmd.Soft(0.5), **TRUTH)
    free = lgmd.Free(k=(0.1, 2), gain=None, baseline=(0, 20), latency=(0, 100))
    fit = lgmd.fit(
        model_of(lgmd.Soft(0.5), theta2=1.5, tau3=250.0),
        conditions(looms, truth, "rate", observation=OBSERVATION),
        free,
        key=KEY,
        **QUICK,
    )
    values = {"k": 0.4, "gain": 80, "baseline": 5, "latency": 30}
    for name, value in values.items():
        np.testing.assert_allclose(fit.values[name], value, rtol=1e-3)
    rate = OBSERVATION(truth(looms[0].frames, 60.0).smp_adapted, looms[0].time)
    np.testing.assert_allclose(fit.predict(looms[0]), rate, atol=0.05)


def test_the_same_key_gives_the_same_fit_and_finished_work_is_not_done_again(looms, soft_fit, monkeypatch):
    soft, memory = lgmd.Soft(1.0), {}
    arguments = model_of(soft), conditions(looms, model_of(soft, **TRUTH)), FREE
    first = lgmd.fit(*arguments, key=KEY, **QUICK, memory=memory)
    assert first.values == soft_fit.values
    assert [run.history for run in first.runs] == [run.history for run in soft_fit.runs]
    for task in [name for name in memory if name.startswith("descending")][1:]:
        del memory[task]
    calls = []
    monkeypatch.setattr(_search, "descend", lambda *args, descend=_search.descend: calls.append(1) or descend(*args))
    again = lgmd.fit(*arguments, key=KEY, **QUICK, memory=memory)
    assert again.values == soft_fit.values
    assert [run.loss for run in again.runs] == [run.loss for run in soft_fit.runs]
    assert len(calls) == 2  # the one that compiles, and the run that was missing


def test_another_fit_of_the_same_shape_traces_nothing(looms, soft_fit, monkeypatch):
    traces = []
    residuals = _problem.Problem.residuals
    monkeypatch.setattr(_problem.Problem, "residuals", lambda *args: traces.append(1) or residuals(*args))
    soft = lgmd.Soft(1.0)
    truth = model_of(soft, theta2=2.0, k=0.6, tau3=400.0)
    fit = lgmd.fit(model_of(soft), conditions(looms, truth), FREE, key=jax.random.key(2), **QUICK)
    np.testing.assert_allclose(fit.values["k"], 0.6, rtol=1e-3)
    assert not traces


def test_ctrl_c_keeps_the_best_so_far(looms, soft_fit):
    class Interrupted(dict):
        def __setitem__(self, key, value):
            super().__setitem__(key, value)
            if key == "screening 3":
                raise KeyboardInterrupt

    soft = lgmd.Soft(1.0)
    arguments = model_of(soft), conditions(looms, model_of(soft, **TRUTH)), FREE
    memory = Interrupted()
    fit = lgmd.fit(*arguments, key=KEY, **QUICK, memory=memory)
    assert fit.result == "stopped by hand"
    assert np.isfinite(fit.loss)
    assert "stopped by hand" in " ".join(fit.remarks())
    resumed = lgmd.fit(*arguments, key=KEY, **QUICK, memory=dict(memory))
    assert resumed.values == soft_fit.values


def test_other_bounds_priors_and_factors_compile_nothing(looms):
    """A trace comes before every compilation; JAX tells of each."""
    traces = []

    def listen(event: str, duration_secs: float, **kwargs: str | int):
        if event == "/jax/core/compile/jaxpr_trace_duration":
            traces.append(kwargs.get("fun_name"))

    soft = lgmd.Soft(1.0)
    model, pairs = model_of(soft), conditions(looms, model_of(soft, **TRUTH), noise=0.01, key=KEY)
    choices = {
        "first": {"k": lgmd.Log(0.1, 2, prior=(0.5, 0.1)), "tau3": (100, 1000), "theta1": lgmd.Tie("theta2", 0.5)},
        "other": {"k": lgmd.Log(0.2, 3, prior=(0.4, 0.2)), "tau3": (90, 900), "theta1": lgmd.Tie("theta2", 0.6)},
    }
    fits = {}
    for name, bounds in choices.items():
        traces.clear()
        jax.monitoring.register_event_duration_secs_listener(listen)
        fits[name] = lgmd.fit(model, pairs, lgmd.Free(theta2=(1, 6), **bounds), key=KEY, **QUICK)
        fits[name].profile("k")
        jax.monitoring.clear_event_listeners()
        assert bool(traces) == (name == "first"), traces
    assert fits["first"].values != fits["other"].values
    anew = jax.jit(lambda free, z: free.values(z)["theta1"])
    for name, factor in (("first", 0.5), ("other", 0.6)):
        np.testing.assert_allclose(anew(fits[name].free, np.array([0.5, 0.5, 0.5])), 3.5 * factor)


@pytest.mark.parametrize("other", ["data", "bounds", "model", "settings"])
def test_the_memory_of_another_fit_is_refused_and_kept(looms, other):
    """The first screening alone is enough to be recognised; nothing of it must pass for a result of this fit."""

    class Interrupted(dict):
        def __setitem__(self, key, value):
            super().__setitem__(key, value)
            if key == "screening 0":
                raise KeyboardInterrupt

    soft, memory = lgmd.Soft(1.0), Interrupted()
    quick: dict[str, Any] = QUICK | {"pixel_points": 1}
    lgmd.fit(model_of(soft), conditions(looms, model_of(soft, **TRUTH)), FREE, key=KEY, **quick, memory=memory)
    changed: dict[str, tuple[Any, ...]] = {
        "data": (model_of(soft), conditions(looms, model_of(soft, k=0.5)), FREE, quick),
        "bounds": (model_of(soft), conditions(looms, model_of(soft, **TRUTH)), FREE.also(k=(0.1, 2.1)), quick),
        "model": (model_of(soft, sigma_sp=0.2), conditions(looms, model_of(soft, **TRUTH)), FREE, quick),
        "settings": (model_of(soft), conditions(looms, model_of(soft, **TRUTH)), FREE, quick | {"max_steps": 9}),
    }
    model, pairs, free, settings = changed[other]
    before = dict(memory)
    with pytest.raises(ValueError, match="memory keeps the work of another fit"):
        lgmd.fit(model, pairs, free, key=KEY, **settings, memory=memory)
    assert memory == before


@pytest.mark.slow
@pytest.mark.parametrize("solver", [optx.LevenbergMarquardt(1e-6, 1e-9), optx.BFGS(1e-6, 1e-12)], ids=["lm", "bfgs"])
def test_other_solvers_of_optimistix(looms, solver):
    soft = lgmd.Soft(1.0)
    arguments = model_of(soft), conditions(looms, model_of(soft, **TRUTH)), FREE
    fit = lgmd.fit(*arguments, key=KEY, solver=solver, **QUICK)
    for name, value in TRUTH.items():
        np.testing.assert_allclose(fit.values[name], value, rtol=0.02)


@pytest.mark.slow
def test_a_robust_loss_is_not_pulled_by_outliers(looms):
    soft = lgmd.Soft(1.0)
    truth = model_of(soft, **TRUTH)
    with_outliers = []
    for stimulus in looms:
        curve = np.array(truth(stimulus.frames, 60.0).smp_adapted)
        curve[10::17] += 0.3
        with_outliers.append((stimulus, lgmd.Target("smp_adapted", curve, error=0.005)))
    off = {}
    for loss in ("squares", "cauchy"):
        fit = lgmd.fit(model_of(soft), with_outliers, FREE, key=KEY, loss=loss, **QUICK)
        off[loss] = max(abs(fit.values[name] / value - 1) for name, value in TRUTH.items())
    assert off["cauchy"] < 0.02 < off["squares"]


def test_ties_and_priors(looms):
    """A prior as precise as the data, two of their standard errors away, draws the value half the way."""
    soft = lgmd.Soft(1.0)
    truth = model_of(soft, **TRUTH)
    known = [(stimulus, lgmd.Weighted(lgmd.ModelTarget(model=truth), error=1e-3)) for stimulus in looms]

    def fit_of(k):
        free = lgmd.Free(k=k, theta2=(1, 6), theta1=lgmd.Tie("theta2"))
        return lgmd.fit(model_of(soft, tau3=250.0), known, free, key=KEY, **QUICK)

    alone = fit_of(lgmd.Log(0.1, 2))
    assert alone.parameters.theta1 == alone.parameters.theta2
    error = alone.uncertainty.standard_errors[alone.free.names.index("k")]
    with_prior = fit_of(lgmd.Log(0.1, 2, prior=(alone.values["k"] + 2 * error, error)))
    np.testing.assert_allclose((with_prior.values["k"] - alone.values["k"]) / error, 1, atol=0.05)
    np.testing.assert_allclose(with_prior.uncertainty.standard_errors[0] / error, np.sqrt(0.5), rtol=0.05)


def test_degenerate_cases_end_well(looms):
    """No influence: undetermined. A saturated start: not trapped. A target out of reach: said."""
    soft = lgmd.Soft(1.0)
    truth = model_of(soft, **TRUTH)
    free = lgmd.Free(k=(0.01, 2), T_sp=None, theta2=(1, 6))
    saturated = model_of(soft, k=0.01, theta2=6.0, tau3=250.0)
    fit = lgmd.fit(saturated, conditions(looms, truth), free, key=KEY, **QUICK)
    np.testing.assert_allclose(fit.values["k"], TRUTH["k"], rtol=1e-3)
    u = fit.uncertainty
    place = u.names.index("T_sp")
    assert not u.determined[place]
    assert np.isinf(u.standard_errors[place])
    assert "T_sp" in " ".join(fit.remarks())
    unreachable = [(stimulus, lgmd.Target("smp_adapted", np.full(len(stimulus.time), 0.9))) for stimulus in looms]
    fit = lgmd.fit(saturated, unreachable, free, key=KEY, **QUICK)
    assert np.isfinite(fit.loss)
    assert "2 of 2 targets are missed" in " ".join(fit.remarks())
    assert {curve.grade for curve in fit.curves} == {"missed"}


def test_the_next_stimulus_is_the_one_that_shows_the_parameter(looms):
    """T_sp shows in spikes alone: a stimulus that makes the cell spike beats one that leaves it at rest."""
    soft = lgmd.Soft(1.0)
    truth = model_of(soft, **TRUTH)
    free = lgmd.Free(k=(0.1, 2), T_sp=None)
    shown = [(looms[0], lgmd.Weighted(lgmd.ModelTarget(model=truth, channel="spikes"), error=0.1))]
    fit = lgmd.fit(model_of(soft, theta2=1.5, tau3=250.0), shown, free, key=KEY, **QUICK)
    nothing = lgmd.stimuli.luminance(EYE, level=199.0, background=200.0, ramp_ms=0.0, hold_ms=300.0)
    ranked = fit.next_stimulus([nothing, looms[0]])
    assert [candidate.name for candidate in ranked] == ["looming", "luminance"]
    # What was seen once is seen again: the information doubles, and errors shrink by the root of 2.
    np.testing.assert_allclose(ranked[0].gain, 2 * np.log(2), rtol=0.02)
    np.testing.assert_allclose(list(ranked[0].shrink.values()), np.sqrt(0.5), rtol=0.02)
    assert 0 <= ranked[1].gain < 1e-6


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"conditions": []}, "conditions is empty"),
        ({"free": lgmd.Free(k=(2, 3))}, "k starts at 1, outside of its bounds"),
        ({"free": lgmd.Free(k=(0.1, 2), gain=None)}, "gain is free, but no target is a rate"),
        ({"temperatures": []}, "temperatures is"),
        ({"temperatures": [0.1, 0.5]}, "give falling numbers"),
        ({"temperatures": [-1.0]}, "positive numbers"),
        ({"temperatures": 0.5}, "temperatures is 0.5; give a list of numbers"),
        ({"solver": optx.BFGS}, "solver is the class BFGS; give one of optimistix'"),
        ({"choose": 3}, "choose is 3; give a function"),
        ({"memory": []}, r"memory is \[\]; give a dict"),
        ({"observation": "rate"}, "observation is 'rate'; give an Observation"),
        ({"free": {"k": (0.1, 2)}}, r"free is \{'k': \(0.1, 2\)\}; give which parameters may change"),
        ({"model": lgmd.LGMD2}, "model is the class LGMD2; give a model, such as lgmd2jax.LGMD2"),
        ({"loss": "absolute"}, "loss is 'absolute'; choose"),
        ({"pixel_points": 0}, "pixel_points is 0; give a whole number"),
        ({"descend": 1.5}, "descend is 1.5"),
    ],
)
def test_misuse_is_refused(looms, untyped, changes, message):
    model, truth = (model_of(lgmd.Hard(), **parameters) for parameters in ({}, TRUTH))
    with pytest.raises(ValueError, match=message):
        lgmd.fit(**{"model": model, "conditions": conditions(looms, truth), "free": FREE, "key": KEY} | changes)


def test_targets_that_do_not_fit_are_refused_by_name(looms):
    values = np.full(len(looms[0].time), 0.5)
    short = [(looms[0], lgmd.Target("smp_adapted", values[:-1]))]
    with pytest.raises(ValueError, match="condition 'looming': the target has"):
        lgmd.fit(model_of(lgmd.Hard()), short, FREE, key=KEY)
    one = [(looms[0], lgmd.Target("smp_adapted", values, weight=(np.arange(len(values)) < 2).astype(float)))]
    with pytest.raises(ValueError, match="3 parameters are free, but the targets hold only 2 independent"):
        lgmd.fit(model_of(lgmd.Hard()), one, FREE, key=KEY)
    correlated = [(looms[0], lgmd.Target("smp_adapted", values, correlation_ms=500.0))]
    with pytest.raises(ValueError, match=r"only 1\.\d+ independent"):
        lgmd.fit(model_of(lgmd.Hard()), correlated, FREE, key=KEY)
    with pytest.raises(ValueError, match="condition 'looming' has no target"):
        lgmd.fit(model_of(lgmd.Hard()), [(looms[0], [])], FREE, key=KEY)


def test_throw_raises_where_the_fit_did_not_converge(looms):
    soft = lgmd.Soft(1.0)
    arguments = model_of(soft), conditions(looms, model_of(soft, **TRUTH)), FREE
    with pytest.raises(RuntimeError, match="did not converge: stopped after 5 steps"):
        lgmd.fit(*arguments, key=KEY, throw=True, max_steps=1, **QUICK)
