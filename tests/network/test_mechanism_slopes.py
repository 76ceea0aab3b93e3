"""Derivatives with respect to the parameters of the optional mechanisms."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from tests import oracle
from tests.network.test_mechanisms import EVERY, FRAMES, PARAMETERS, WITH_LAMINA, values
from tests.network.test_sensitivity import assert_close, maps_carried, plain

NAMES = list(lgmd.symbols())
CLIP = jnp.asarray(FRAMES)
FPS = 24.0  # not that of the reference of change per time


def channels(parameters, model):
    response = dataclasses.replace(model, parameters=parameters)(CLIP, FPS)
    return jnp.stack([getattr(response, channel) for channel in oracle.CHANNELS])


def in_factors(factors, model):
    """The channels with each parameter times its factor; a lag of 37 ms is .89 frames."""
    return channels(lgmd.Parameters(**{name: values()[name] * factors[i] for i, name in enumerate(NAMES)}), model)


@pytest.mark.parametrize(
    ("mode", "structure", "mechanisms"),
    [
        (jax.jacfwd, {"n_p": 1, "low_pass": "exact"}, EVERY),
        (jax.jacfwd, {}, WITH_LAMINA),
        pytest.param(jax.jacrev, {}, WITH_LAMINA, marks=pytest.mark.slow),
        pytest.param(jax.jacrev, {"n_p": 1, "low_pass": "exact"}, EVERY, marks=pytest.mark.slow),
        pytest.param(jax.jacfwd, {}, ("size", "lag"), marks=pytest.mark.slow),
        pytest.param(jax.jacrev, {}, EVERY, marks=pytest.mark.slow),
    ],
)
def test_equals_central_differences(mode, structure, mechanisms):
    model = lgmd.LGMD2(PARAMETERS, lgmd.Soft(1.0), mechanisms=mechanisms, **structure)
    ones, step = np.ones(len(NAMES)), 2e-5
    shifts = step * np.concatenate([np.eye(len(NAMES)) * by for by in (1, -1, 0.5, -0.5)])
    run = jax.jit(jax.vmap(lambda factors: in_factors(factors, model)))
    above, below, near_above, near_below = np.split(np.asarray(run(jnp.asarray(ones + shifts))), 4)
    coarse, fine = (above - below) / (2 * step), (near_above - near_below) / step
    expected = np.moveaxis((4 * fine - coarse) / 3, 0, -1)
    slopes = np.asarray(jax.jit(mode(lambda factors: in_factors(factors, model)))(jnp.asarray(ones)))
    for channel, found, wanted in zip(oracle.CHANNELS, slopes, expected, strict=True):
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-6 * np.abs(wanted).max(), err_msg=channel)


def sums_by_parameters(rule, thresholds, **structure):
    def run(parameters):
        model = lgmd.LGMD2(parameters, thresholds, **{"mechanisms": ("size",), **structure})
        return rule(model, CLIP, jnp.asarray(1000 / 30))

    return jax.jit(jax.jacfwd(run))(PARAMETERS)


@pytest.mark.parametrize(
    ("thresholds", "structure"),
    [
        (lgmd.Soft(0.5), {"n_p": 2, "low_pass": "exact"}),
        (lgmd.Soft(0.5), {"mechanisms": ("size", "lamina")}),
        (lgmd.Soft(0.5), {"mechanisms": ("size", "habituation")}),
        pytest.param(lgmd.StraightThrough(0.5), {"mechanisms": ("size", "lamina")}, marks=pytest.mark.slow),
        pytest.param(lgmd.StraightThrough(0.5), {}, marks=pytest.mark.slow),
        pytest.param(lgmd.Soft(0.5), {}, marks=pytest.mark.slow),
        pytest.param(lgmd.StraightThrough(0.5), {"n_p": 2, "low_pass": "exact"}, marks=pytest.mark.slow),
        pytest.param(lgmd.Hard(), {"n_p": 1}, marks=pytest.mark.slow),
    ],
    ids=lambda of: str(of) if isinstance(of, dict) else type(of).__name__,
)
def test_the_exact_sensitivities_are_the_plain_ones(thresholds, structure):
    found = sums_by_parameters(lambda model, *clip: model.sums(*clip)[0], thresholds, **structure)
    assert_close(found, sums_by_parameters(plain, thresholds, **structure))
    if not isinstance(thresholds, lgmd.Hard):
        of_f = {name for name in NAMES if np.any(getattr(found.f, name))}
        mechanisms = structure.get("mechanisms", ())
        of_p = {"u"} if structure.get("n_p") else {"tau_lamina"} if "lamina" in mechanisms else set()
        assert of_f == {"tau1", "sigma1", "T_p", "tau_hold"} | of_p
        assert all(np.any(getattr(found.mp, name)) == ("habituation" in mechanisms) for name in ("tau_hab", "S_hab"))


def test_the_fast_scan_is_the_plain_one():
    for thresholds in (lgmd.Hard(), lgmd.Soft(0.5)):
        model = lgmd.LGMD2(PARAMETERS, thresholds, n_p=1, mechanisms=("size",))
        interval = jnp.asarray(1000 / 30)
        assert_close(model.sums(CLIP, interval)[0], plain(model, CLIP, interval), 1e-12)


@pytest.mark.parametrize(
    ("mechanisms", "n_p", "of_p", "kept"), [(EVERY, 2, "u", 2), (WITH_LAMINA, 0, "tau_lamina", 1)], ids=["u", "lamina"]
)
def test_only_what_is_perturbed_and_remembers_carries_maps(mechanisms, n_p, of_p, kept):
    """M is held without a border, so the clip is so large here that a map of either kind counts as one."""
    fatigue = int("habituation" in mechanisms)
    # ON, OFF, D_on, D_off, M, those of P, one to lay a border onto, and B
    frames, own = jnp.zeros((3, 50, 60)), 6 + kept + fatigue
    more = {"tau1": 3 + fatigue, "sigma1": 5 + fatigue, of_p: 5 + kept + fatigue, "T_p": 1, "tau_hold": 1}
    more |= {"tau_hab": fatigue, "S_hab": fatigue}
    for name in ("tau1", of_p, "T_p", "tau_hold", "A_ffi", "lag", *(("tau_hab", "S_hab") if fatigue else ())):

        def response(value, name=name):
            parameters = dataclasses.replace(PARAMETERS, **{name: value})
            model = lgmd.LGMD2(parameters, lgmd.Soft(0.5), n_p=n_p, mechanisms=mechanisms)
            return model(frames, 30.0).smp_adapted

        carried = maps_carried(jax.jacfwd(response), getattr(PARAMETERS, name), size=50 * 60)
        assert carried == own + more.get(name, 0), name


@pytest.mark.parametrize("form", ["backward_euler", "exact"])
def test_finite_at_the_ends_of_the_domain(form):
    """Without a membrane, without a lag, and late by a whole frame, where the slope jumps."""

    def run(values):
        parameters = dataclasses.replace(PARAMETERS, tau_cell=values[0], lag=values[1])
        return channels(parameters, lgmd.LGMD2(thresholds=lgmd.Soft(), low_pass=form, mechanisms=EVERY))

    ends = jnp.array([[0.0, 0.0], [0.0, 1000 / FPS]])
    assert np.all(np.isfinite(jax.jit(jax.vmap(jax.jacfwd(run)))(ends)))
