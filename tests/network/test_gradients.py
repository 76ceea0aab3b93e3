"""Derivatives of the network with respect to every parameter and to the frames."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from tests import clips, oracle

PARAMETERS = lgmd.Parameters(
    theta1=0.4, theta2=1.3, theta3=0.02, T_s=15.0, T_ffi=46.0, T_sfa=0.06, tau3=400.0, k=60.0, T_sp=0.6, u=0.7, N_sp=3.0
)
FRAMES = jnp.asarray(clips.loom(3, (12, 7, 8)) + 3 * clips.noise(8, (12, 7, 8)) / 245)
SOFT = [lgmd.Soft(1.0), lgmd.Soft(0.3)]
STRUCTURES = [{}, pytest.param({"n_p": 2, "low_pass": "exact", "N_ts": 2}, marks=pytest.mark.slow)]


def channels(parameters, frames, thresholds=SOFT[0], **structure):
    response = lgmd.LGMD2(parameters, thresholds, **structure)(frames, 30.0)
    return {name: getattr(response, name) for name in oracle.CHANNELS}


def assert_close(found, expected, tolerance=1e-6):
    for name in oracle.CHANNELS:
        largest = np.abs(expected[name]).max()
        np.testing.assert_allclose(found[name], expected[name], atol=tolerance * largest, rtol=0, err_msg=name)


def central_difference(function, value, step):
    """Extrapolated from two steps, so that it is good to the fourth order."""

    def slope(step):
        above, below = function(value + step), function(value - step)
        return jax.tree.map(lambda a, b: (a - b) / (2 * step), above, below)

    return jax.tree.map(lambda fine, coarse: (4 * fine - coarse) / 3, slope(step / 2), slope(step))


@pytest.mark.parametrize("structure", STRUCTURES, ids=str)
def test_parameters(structure):
    def run(parameters, thresholds):
        return channels(parameters, FRAMES, thresholds, **structure)

    value_of, forward, reverse = jax.jit(run), jax.jit(jax.jacfwd(run)), jax.jit(jax.jacrev(run))
    for thresholds in SOFT:
        expected = []
        for name in lgmd.symbols():
            value = float(getattr(PARAMETERS, name))

            def shifted(x, name=name, thresholds=thresholds):
                return value_of(eqx.tree_at(lambda p: getattr(p, name), PARAMETERS, jnp.asarray(x)), thresholds)

            slope = central_difference(shifted, value, 2e-5 * value)
            influences = any(np.any(slope[channel]) for channel in oracle.CHANNELS)
            assert influences == (name not in lgmd.LGMD2(**structure).unused), name
            expected.append({channel: value * slope[channel] for channel in oracle.CHANNELS})
        expected = {channel: np.stack([slope[channel] for slope in expected]) for channel in oracle.CHANNELS}
        for mode in (forward, reverse):
            jacobian = mode(PARAMETERS, thresholds)
            assert_close(
                {
                    channel: np.stack(
                        [getattr(jacobian[channel], name) * getattr(PARAMETERS, name) for name in lgmd.symbols()]
                    )
                    for channel in oracle.CHANNELS
                },
                expected,
            )


def test_frames():
    def run(frames):
        return channels(PARAMETERS, frames, n_p=1)

    direction = jnp.asarray(clips.noise(9, (12, 7, 8)) - 128) / 100
    expected = central_difference(lambda x: run(FRAMES + x * direction), 0.0, 1e-5)
    _, forward = jax.jvp(run, (FRAMES,), (direction,))
    assert_close(forward, expected)
    reverse = jax.jacrev(run)(FRAMES)
    assert_close({name: jnp.tensordot(reverse[name], direction, axes=3) for name in oracle.CHANNELS}, expected)


def test_a_single_pixel():
    def run(level):
        return channels(PARAMETERS, FRAMES.at[6, 2, 3].set(level))

    level = float(FRAMES[6, 2, 3])
    assert_close(jax.jacfwd(run)(level), central_difference(run, level, 1e-4))


def test_straight_through_takes_the_plain_chain_rule():
    """With the gate open or shut for good, only the S gate is left, and its chain rule can be written down."""
    parameters = lgmd.Parameters(theta1=0.4, T_ffi=1e6, sigma1=0.0)
    layers = lgmd.LGMD2(parameters)(FRAMES, 30.0, record=lambda layers: layers.s).recorded
    z = (layers - 10) / 1.0
    slope = jax.nn.sigmoid(z) * (1 - jax.nn.sigmoid(z)) / 1.0
    gradient = jax.jacfwd(lambda p: lgmd.LGMD2(p, lgmd.StraightThrough(1.0))(FRAMES, 30.0).mp)(parameters)
    # The width is .1 T_s, so the slope with respect to T_s is that of sigma((S - T_s)/(.1 T_s)).
    expected = jnp.sum(-layers * slope * (layers / parameters.T_s), axis=(1, 2))
    np.testing.assert_allclose(gradient.T_s, expected, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("thresholds", [lgmd.Soft(), lgmd.StraightThrough()], ids=["soft", "straight-through"])
def test_under_vmap(thresholds):
    batch = jnp.stack([jnp.asarray(clips.loom(seed, (8, 5, 6))) for seed in range(3)])

    def loss(parameters, frames):
        return lgmd.LGMD2(parameters, thresholds)(frames, 30.0).smp_adapted.sum()

    slope = jax.jit(jax.grad(loss))
    together = jax.jit(jax.vmap(slope, in_axes=(None, 0)))(PARAMETERS, batch)
    for i, frames in enumerate(batch):
        single = slope(PARAMETERS, frames)
        for name in lgmd.symbols():
            np.testing.assert_allclose(getattr(together, name)[i], getattr(single, name), rtol=1e-9, atol=1e-12)


def test_second_derivatives_exist():
    def loss(theta2):
        parameters = eqx.tree_at(lambda p: p.theta2, PARAMETERS, theta2)
        return channels(parameters, FRAMES)["smp"].sum()

    theta2 = jnp.asarray(1.3)
    expected = central_difference(jax.jit(jax.grad(loss)), theta2, 1e-4)
    np.testing.assert_allclose(jax.jit(jax.hessian(loss))(theta2), expected, rtol=1e-5)


STEPS = jnp.arange(12.0)[:, None, None] * jnp.full(FRAMES.shape, 10.0)
STEPS_ALONE = lgmd.Parameters(theta1=1.0, w_bias=0.0, sigma1=0.0, tau2=1e-9)
HARD_CASES = {
    "rest": (PARAMETERS, jnp.full(FRAMES.shape, 100.0)),
    "saturation": (lgmd.Parameters(theta2=6.0, k=1e-3, T_ffi=1e6), FRAMES),
    "silenced": (lgmd.Parameters(T_ffi=1e-3), FRAMES),
    # S = 0 = T_s, d = 0 = T_sfa, Fbar = 0 and MP = 0 at rest: each exactly on its threshold.
    "on thresholds": (lgmd.Parameters(theta1=1.0, T_s=0.0, T_sfa=0.0), jnp.full(FRAMES.shape, 100.0)),
    # Steps of 10 with neither inhibition nor memory: S = ON is exactly T_s, and Fbar = F exactly T_ffi.
    "on T_s and T_ffi": (
        eqx.tree_at(lambda p: p.T_ffi, STEPS_ALONE, lgmd.LGMD2(STEPS_ALONE)(STEPS, 30.0).ffi[-1]),
        STEPS,
    ),
    "no weight": (lgmd.Parameters(theta1=0.0, theta2=0.0, w_bias=0.0, sigma1=0.0, sigma_sp=0.0), FRAMES),
}


@eqx.filter_jit
def slopes_of_everything(parameters, frames, thresholds):
    def loss(parameters, frames):
        out = channels(parameters, frames, thresholds)
        return sum(jnp.sum(out[name]) for name in oracle.CHANNELS)

    return jax.grad(loss, argnums=(0, 1))(parameters, frames)


@pytest.mark.parametrize(
    "thresholds",
    [lgmd.Hard(), lgmd.Soft(), lgmd.Soft(1e-3), lgmd.StraightThrough()],
    ids=["hard", "soft", "cold", "st"],
)
@pytest.mark.parametrize("case", HARD_CASES)
@pytest.mark.parametrize("dtype", [jnp.float32, jnp.float64])
def test_finite_where_it_is_hard(case, thresholds, dtype):
    parameters, frames = jax.tree.map(lambda leaf: leaf.astype(dtype), HARD_CASES[case])
    gradient = slopes_of_everything(parameters, frames, thresholds)
    assert all(bool(jnp.all(jnp.isfinite(leaf))) for leaf in jax.tree.leaves(gradient))


def test_one_case_lies_exactly_on_its_thresholds():
    parameters, frames = HARD_CASES["on T_s and T_ffi"]
    response = lgmd.LGMD2(parameters)(frames, 30.0, record=lambda layers: layers.s)
    assert np.all(response.recorded[1:] == parameters.T_s)
    assert response.ffi[-1] == parameters.T_ffi
