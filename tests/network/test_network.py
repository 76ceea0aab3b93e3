"""The network against loops over pixels, its identities, its limit in temperature."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax import hard
from tests import clips, oracle
from tests.releases import AFTER_JAX_0_10

# Presets as in the paper, and one set in which nothing is zero and every threshold is crossed by noise.
SETS = {name: {} | dict(lgmd.PRESETS[name]) for name in lgmd.PRESETS}
SETS["all"] = {
    "theta1": 0.4,
    "theta2": 1.3,
    "theta3": 0.02,
    "T_ffi": 60.0,
    "k": 40.0,
    "T_sp": 0.6,
    "u": 0.7,
    "T_s": 15.0,
}
STRUCTURES = [
    {"n_p": n_p, "low_pass": low_pass} for n_p in (0, 1) for low_pass in ("backward_euler", "exact")
] + [{"n_p": 3, "N_ts": 0}]  # fmt: skip
FRAMES = {
    "noise": clips.noise(0, (8, 5, 7)),
    "smallest": clips.noise(1, (6, 3, 3)),
    "narrow": clips.noise(2, (6, 3, 8)),
    "loom": clips.loom(),
}
CASES = [("noise", name) for name in SETS] + [
    ("loom", "lgmd2"),
    ("smallest", "all"),
    ("narrow", "all"),
    ("loom", "all"),
]


def values(parameters: lgmd.Parameters) -> dict[str, float]:
    return {name: float(getattr(parameters, name)) for name in lgmd.symbols()}


def assert_equal(found, expected, channels=oracle.CHANNELS):
    """To 1e-10 of the largest value of each channel."""
    for channel in channels:
        atol = 1e-10 * np.abs(expected[channel]).max()
        np.testing.assert_allclose(found[channel], expected[channel], atol=atol, rtol=0, err_msg=channel)


def some_layers(layers):
    return {"s": layers.s, "s_gated": layers.s_gated, "g": layers.g}


@pytest.mark.parametrize("structure", STRUCTURES, ids=str)
@pytest.mark.parametrize("temperature", [None, 0.3, 1.0])
@pytest.mark.parametrize(("clip", "name"), CASES)
def test_agrees_with_loops_over_pixels(clip, temperature, name, structure):
    frames, parameters = FRAMES[clip], lgmd.Parameters(**SETS[name])
    thresholds = lgmd.Hard() if temperature is None else lgmd.Soft(temperature)
    model = lgmd.LGMD2(parameters, thresholds, **structure)
    response = model(frames, 30.0, record=some_layers)
    expected = oracle.respond(frames.tolist(), 30.0, values(parameters), temperature, **structure)
    assert_equal(vars(response), expected)
    assert_equal(response.recorded, expected, ("s", "s_gated", "g"))


@pytest.mark.parametrize("structure", STRUCTURES, ids=str)
@pytest.mark.parametrize(("clip", "name"), CASES)
def test_numpy_model_agrees_with_loops_over_pixels(clip, name, structure):
    frames, v = FRAMES[clip], values(lgmd.Parameters(**SETS[name]))
    response = hard.HardLGMD2(v, 30.0, **{"n_p": 0, **structure})(frames)
    expected = oracle.respond(frames.tolist(), 30.0, v, **structure)
    assert_equal(response._asdict(), expected)


@pytest.mark.parametrize("temperature", [None, 1.0])
@pytest.mark.parametrize("name", SETS)
def test_single_precision_agrees_with_loops_over_pixels(name, temperature):
    frames, parameters = clips.noise(3, (12, 11, 13)).astype(np.float32), lgmd.Parameters(**SETS[name])
    single = jax.tree.map(lambda leaf: leaf.astype(jnp.float32), parameters)
    thresholds = lgmd.Hard() if temperature is None else lgmd.Soft(temperature)
    response = lgmd.LGMD2(single, thresholds)(frames, 30.0)
    assert response.mp.dtype == response.smp_adapted.dtype == jnp.float32
    expected = oracle.respond(frames.tolist(), 30.0, values(parameters), temperature)
    near = np.sum(np.abs(np.array(expected["s"]) - parameters.T_s) <= 1e-4 * float(parameters.T_s), axis=(1, 2))
    allowed = 1e-4 * np.max(expected["mp"]) + (
        near * float(parameters.T_s * parameters.theta2) if temperature is None else 0
    )
    assert np.all(np.abs(response.mp - np.array(expected["mp"])) <= allowed)
    np.testing.assert_allclose(response.ffi, expected["ffi"], rtol=1e-5)
    if temperature is not None:
        np.testing.assert_allclose(response.smp_adapted, expected["smp_adapted"], atol=1e-4)


@pytest.mark.parametrize("precision", ["uint8", "float32", "float64"])
@pytest.mark.parametrize(
    "thresholds", [lgmd.Hard(), lgmd.Soft(1.0), lgmd.StraightThrough(0.5)], ids=["hard", "soft", "st"]
)
@pytest.mark.parametrize("shape", [(9, 7, 9), (6, 48, 64)])
def test_stepping_equals_the_scan(shape, thresholds, precision):
    """To the bit where XLA compiles both alike; else but for rounding of the pixels, which thresholds make steep."""
    frames = clips.noise(4, shape).astype(precision)
    model = lgmd.LGMD2(lgmd.Parameters(**SETS["all"]), thresholds, n_p=1)
    clip = model(frames, 30.0)
    closed_over = eqx.filter_jit(lambda state, frame: model.step(state, frame, 30.0))
    passed = eqx.filter_jit(model.step)
    state = model.init(frames[0])
    for t, frame in enumerate(frames):
        _, again = closed_over(state, frame)
        state, now = passed(state, frame, 30.0)
        for channel in oracle.CHANNELS:
            whole = getattr(clip, channel)
            rounding = np.finfo("float32" if precision == "float32" else "float64").eps * np.max(whole)
            steep = 1000 if channel in ("spikes", "collision") else 4
            allowed = steep * rounding if AFTER_JAX_0_10 else 0.0
            for each in (now, again):
                np.testing.assert_allclose(getattr(each, channel), whole[t], rtol=0, atol=allowed, err_msg=channel)


def test_stepping_records_what_the_scan_records():
    frames = clips.noise(4, (6, 7, 9))
    model = lgmd.LGMD2(lgmd.Parameters(**SETS["all"]), n_p=1)
    recorded = model(frames, 30.0, record=some_layers).recorded
    state = model.init(frames[0])
    for t, frame in enumerate(frames):
        state, now = model.step(state, frame, 30.0, record=some_layers)
        for name, layer in recorded.items():
            np.testing.assert_allclose(now.recorded[name], layer[t], rtol=1e-12, atol=1e-10, err_msg=name)


def test_grouping_keeps_the_sum():
    model = lgmd.LGMD2(lgmd.Parameters(**SETS["all"]))
    response = model(clips.noise(5, (7, 6, 9)), 30.0, record=lambda layers: (layers.s_gated, layers.g))
    gated, grouped = response.recorded
    np.testing.assert_allclose(grouped.sum((1, 2)), gated.sum((1, 2)), rtol=1e-12)
    np.testing.assert_allclose(response.mp, grouped.sum((1, 2)), rtol=1e-12)
    assert not np.allclose(grouped, gated)


@pytest.mark.parametrize("name", SETS)
def test_nothing_moves_nothing_fires(name):
    frames = np.repeat(clips.noise(6, (1, 6, 8)), 20, axis=0)
    response = lgmd.LGMD2(lgmd.Parameters(**SETS[name]), n_p=2)(frames, 30.0)
    assert np.all(response.mp == 0)
    assert np.all(response.ffi == 0)
    assert np.all(response.smp_adapted == 0.5)
    assert np.all(response.spikes == 0)
    assert np.all(response.collision == 0)


def test_on_of_the_negative_is_off():
    frames = clips.noise(7, (6, 5, 6))
    flows = [
        lgmd.LGMD2(n_p=1)(clip, 30.0, record=lambda layers: (layers.on, layers.off, layers.d_on, layers.d_off)).recorded
        for clip in (frames, 255 - frames)
    ]
    (on, off, d_on, d_off), (negative_on, negative_off, negative_d_on, negative_d_off) = flows
    for left, right in ((on, negative_off), (off, negative_on), (d_on, negative_d_off), (d_off, negative_d_on)):
        np.testing.assert_allclose(left, right, rtol=1e-12, atol=1e-10)


def test_the_place_of_a_scene_does_not_matter():
    scene = clips.loom(shape=(20, 9, 9))

    def placed(row, col):
        frames = np.full((20, 24, 26), 200.0)
        frames[:, row : row + 9, col : col + 9] = scene
        return lgmd.LGMD2(lgmd.Parameters(**SETS["all"]))(frames, 30.0)

    here, there = placed(3, 4), placed(11, 12)
    assert np.ptp(here.mp) > 1000
    for channel in oracle.CHANNELS:
        np.testing.assert_allclose(getattr(here, channel), getattr(there, channel), rtol=1e-11)


@pytest.mark.parametrize("thresholds", [lgmd.Hard(), lgmd.Soft()], ids=["hard", "soft"])
def test_batch_equals_single(thresholds):
    batch = np.stack([clips.loom(seed) for seed in range(5)]).astype(np.float32)
    model = lgmd.LGMD2(lgmd.Parameters(theta1=0.5, k=20.0), thresholds)
    together = jax.vmap(model, in_axes=(0, None))(batch, 30.0)
    for i, clip in enumerate(batch):
        single = model(clip, 30.0)
        for channel in oracle.CHANNELS:
            scale = np.abs(getattr(single, channel)).max()
            np.testing.assert_allclose(getattr(together, channel)[i], getattr(single, channel), atol=1e-4 * scale)


def margins(expected, v):
    """Distance of every quantity from its threshold, and whether it was seen on both sides."""
    adapted = np.array(expected["smp_adapted"])
    distances = {
        "s": (np.array(expected["s"]) - v["T_s"], 0.05),
        "ffi": (np.array(expected["ffi"]) - v["T_ffi"], 0.02),
        "sfa": (np.array(expected["rise"]) - v["T_sfa"], 2e-5),
        "floor": (np.array(expected["unfloored"]) - 0.5, 1e-4),
        "one spike": (adapted - v["T_sp"], 5e-4),
        "two spikes": (adapted - v["T_sp"] - v["sigma_sp"], 5e-4),
        "collision": (np.convolve(expected["spikes"], np.ones(5))[: len(adapted)] - v["N_sp"] + 0.5, 0.4),
    }
    clear = all(np.abs(distance).min() > margin for distance, margin in distances.values())
    crossed = all(distance.min() < 0 < distance.max() for distance, _ in distances.values())
    return clear and crossed


def clear_of_thresholds():
    """A clip that crosses every threshold and comes near none, with parameters to match."""
    for seed in range(200):
        frames = clips.loom(seed, shape=(24, 11, 13))
        v = values(lgmd.Parameters(k=8.0, T_ffi=18.0, T_sp=0.62, sigma_sp=0.15, N_sp=3.0, tau3=200.0))
        expected = oracle.respond(frames.tolist(), 30.0, v)
        levels = np.sort(np.ravel(expected["s"]))
        inside = levels[(levels > 5) & (levels < 20)]
        widest = np.argmax(np.diff(inside))
        v["T_s"] = float(inside[widest] + inside[widest + 1]) / 2
        if margins(oracle.respond(frames.tolist(), 30.0, v), v):
            return frames, v
    raise RuntimeError("no clip of 200 is clear of all thresholds")


def test_soft_goes_to_hard():
    frames, v = clear_of_thresholds()
    parameters = lgmd.Parameters(**v)
    hard_response = lgmd.LGMD2(parameters)(frames, 30.0)
    differences = []
    for temperature in (1.0, 0.1, 0.01, 0.001):
        soft = lgmd.LGMD2(parameters, lgmd.Soft(temperature))(frames, 30.0)
        differences.append(
            [
                np.abs(getattr(soft, name) - getattr(hard_response, name)).max() / np.ptp(getattr(hard_response, name))
                for name in oracle.CHANNELS
            ]
        )
    differences = np.array(differences)
    assert differences[0, 0] > 1e-3, "at temperature 1 the soft model should differ"
    assert np.all(np.diff(differences, axis=0) <= 0)
    assert np.all(differences[-1] < 1e-6)
