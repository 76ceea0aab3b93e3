"""The search for a telling stimulus: against a grid, and against the score as it is defined."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd

EYE = lgmd.Eye(rows=8, cols=10, degrees_per_pixel=8.0, fps=30.0)
MODEL = lgmd.LGMD2(lgmd.Parameters(T_s=5.0, T_sfa=5e-4, tau2=300.0, T_ffi=1e9), eye=EYE)
OTHER = lgmd.LGMD2(lgmd.Parameters(T_s=5.0, T_sfa=5e-4, tau2=300.0, k=0.6, T_ffi=1e9), eye=EYE)
WINDOW: dict[str, Any] = {"start_ms": -400, "end_ms": 200}
KEY = jax.random.key(0)


@pytest.fixture(scope="module")
def strongest():
    vary = {"contrast": (-1.0, -0.2), "l_over_v": lgmd.Log(10, 80)}
    return lgmd.strongest_stimulus(MODEL, "looming", vary, key=KEY, starts=2, **WINDOW)


def test_the_strongest_of_a_family_is_at_least_that_of_a_grid(strongest):
    def total(stimulus):
        return float(jnp.sum(MODEL(stimulus.frames).smp_adapted - 0.5) * 1000 / 30)

    grid = [
        lgmd.stimuli.looming(EYE, contrast=contrast, l_over_v=l_over_v, start_ms=-400, end_ms=200)
        for contrast in (-1.0, -0.6, -0.2)
        for l_over_v in (10.0, 28.0, 80.0)
    ]
    assert strongest.score >= 0.99 * max(map(total, grid))
    assert strongest.score == pytest.approx(total(strongest.stimulus))
    assert strongest.measured(grid[0]) == pytest.approx(total(grid[0]))
    assert strongest.score == strongest.scores.max()
    assert strongest.scores.shape == (2, 2)


def test_it_is_one_of_the_family_in_whole_grey_levels(strongest):
    frames = np.asarray(strongest.stimulus.frames)
    np.testing.assert_array_equal(frames, np.rint(frames))
    again = lgmd.stimuli.looming(EYE, **strongest.arguments, start_ms=-400, end_ms=200)
    assert np.abs(np.asarray(again.frames) - frames).max() <= 0.5 + 1e-6
    assert -1 <= strongest.arguments["contrast"] <= -0.2


def test_the_distance_is_that_of_an_observer_under_noise():
    found = lgmd.discriminating_stimulus(
        MODEL, OTHER, "looming", {"l_over_v": (10, 80)}, key=KEY, noise=0.02, starts=1, **WINDOW
    )
    one, other = (model(found.stimulus.frames).smp_adapted for model in (MODEL, OTHER))
    assert found.score == pytest.approx(float(jnp.linalg.norm((one - other) / 0.02)))
    grid = [lgmd.stimuli.looming(EYE, l_over_v=speed, **WINDOW) for speed in (10.0, 28.0, 45.0, 80.0)]
    assert found.score >= 0.99 * max(map(found.measured, grid))


def test_misuse_is_refused(untyped):
    vary = {"l_over_v": (10, 80)}
    for settings, message in (
        ({"family": "loming"}, "family is 'loming'; choose 'looming'"),
        ({"start_ms": None}, None),
        ({"vary": {}}, "vary is empty"),
        ({"vary": {"l_over_v": (80, 10)}}, "l_over_v has the bounds 80 and 10; the first must be below the second"),
        ({"vary": {"l_over_v": lgmd.Log(0, 10)}}, "it must be positive|must be positive"),
        ({"vary": {"speeed": (1, 2)}}, "speeed"),
        ({"measure": "sum"}, "choose 'total' or 'peak'"),
        ({"neuron": lgmd.LGMD2()}, "neuron has no eye"),
    ):
        given: dict[str, Any] = {"neuron": MODEL, "family": "looming", "vary": vary, "key": KEY, **WINDOW, **settings}
        if message is None:
            given.pop("start_ms")
            message = "start_ms is missing; give the window"
        with pytest.raises((ValueError, TypeError), match=message):
            lgmd.strongest_stimulus(given.pop("neuron"), given.pop("family"), given.pop("vary"), **given)
    with pytest.raises(ValueError, match="noise is not given"):
        lgmd.discriminating_stimulus(MODEL, OTHER, "looming", vary, key=KEY, **WINDOW)
