"""The LGMD1 of Yue & Rind: against loops over pixels, in its limit, and beside the LGMD2."""

import dataclasses
import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from tests import clips
from tests.oracle import CHANNELS, WEIGHTS, logistic

EYE = lgmd.Eye(rows=60, cols=80, degrees_per_pixel=None, fps=30.0)
# Every threshold is crossed by noise, and no parameter has its default.
CROSSED: dict[str, Any] = {
    "u": 0.7, "W_I": 0.5, "Delta_C": 0.2, "C_omega": 3.0, "C_de": 0.7, "T_de": 40.0, "T_ffi": 65.0, "alpha_ffi": 0.2,
    "k": 60.0, "T_sp": 0.8,
}  # fmt: skip
SETS = {"published": {}, "crossed": CROSSED}


def model(thresholds: lgmd.Thresholds | None = None, **fields: Any) -> lgmd.YueRindLGMD1:
    return lgmd.YueRindLGMD1(lgmd.YueRindParameters(**CROSSED), thresholds or lgmd.Hard(), **fields)


def values(parameters: lgmd.YueRindParameters) -> dict[str, float]:
    return {name: float(getattr(parameters, name)) for name in lgmd.symbols(lgmd.YueRindParameters)}


def expected(frames, v, temperature=None, N_sp=4):
    """The network once more, as loops over pixels straight from the equations."""
    _, rows, cols = frames.shape
    pixels = [(x, y) for x in range(rows) for y in range(cols)]

    def step(distance, width):
        if temperature is None:
            return 1.0 if distance >= 0 else 0.0
        return logistic(distance / (temperature * width))

    def around(values, x, y, weights):
        total = 0.0
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                row, col = min(max(x + i, 0), rows - 1), min(max(y + j, 0), cols - 1)
                total += weights[i + 1][j + 1] * values[row, col]
        return total

    before, p_before, threshold, run = frames[0], np.zeros((rows, cols)), v["T_ffi"], [0.0] * N_sp
    out = {name: [] for name in (*CHANNELS, "g_kept")}
    for frame in frames:
        p, s, kept = np.zeros((rows, cols)), np.zeros((rows, cols)), np.zeros((rows, cols))
        for x, y in pixels:
            p[x, y] = frame[x, y] - before[x, y] + p_before[x, y] / (1 + math.exp(v["u"]))
            s[x, y] = p[x, y] - v["W_I"] * around(p_before, x, y, WEIGHTS)
        c_e = np.array([[around(s, x, y, [[1 / 9] * 3] * 3) for y in range(cols)] for x in range(rows)])
        omega = v["Delta_C"] + np.abs(c_e).max() / v["C_omega"]
        for x, y in pixels:
            g = s[x, y] * c_e[x, y] / omega
            kept[x, y] = g * step(v["C_de"] * g - v["T_de"], 0.1 * v["T_de"])
        k, f = np.abs(kept).sum(), np.abs(p_before).mean()
        kappa = logistic(k / (rows * cols * v["k"]))
        threshold = v["T_ffi"] + v["alpha_ffi"] * threshold
        inhibited = step(f - threshold, 0.03 * threshold)
        spike = (1 - inhibited) * step(kappa - v["T_sp"], 0.01)
        run = [*run[1:], spike]
        collision = step(sum(run) - (N_sp if temperature is None else N_sp - 0.5), 0.1)
        before, p_before = frame, p
        for name, value in zip(out, (k, f, kappa, kappa, spike, collision, kept), strict=True):
            out[name].append(value)
    return {name: np.array(value) for name, value in out.items()}


def kept(layers):
    return layers.g_kept


@pytest.mark.parametrize("temperature", [None, 0.3])
@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize(
    "frames", [clips.noise(0, (12, 5, 7)), clips.noise(1, (6, 3, 3)), clips.loom()], ids=["noise", "smallest", "loom"]
)
def test_agrees_with_loops_over_pixels(frames, name, temperature):
    thresholds = lgmd.Hard() if temperature is None else lgmd.Soft(temperature)
    parameters = lgmd.YueRindParameters(**SETS[name])
    response = lgmd.YueRindLGMD1(parameters, thresholds, N_sp=2)(frames, 30.0, record=kept)
    wanted = expected(frames, values(parameters), temperature, N_sp=2)
    found = vars(response) | {"g_kept": response.recorded}
    for channel, value in wanted.items():
        np.testing.assert_allclose(found[channel], value, atol=1e-10 * np.abs(value).max(), rtol=0, err_msg=channel)


def test_the_clip_for_it_crosses_every_threshold():
    out = expected(clips.noise(0, (12, 5, 7)), CROSSED, N_sp=2)
    assert 0 < np.mean(out["g_kept"] == 0) < 1
    assert 0 < out["collision"].sum() < out["spikes"].sum() < np.sum(out["smp"] >= 0.8) < 12


@pytest.mark.parametrize("thresholds", [lgmd.Hard(), lgmd.Soft(1.0), lgmd.StraightThrough(0.5)], ids=str)
@pytest.mark.parametrize(("shape", "precision"), [((9, 7, 9), "uint8"), ((4, 48, 64), "float64")])
def test_stepping_equals_the_scan_to_the_bit(shape, thresholds, precision):
    frames, network = clips.noise(4, shape).astype(precision), model(thresholds)
    clip, state = network(frames, 30.0), network.init(frames[0])
    for t, frame in enumerate(frames):
        state, now = network.step(state, frame, 30.0)
        for channel in CHANNELS:
            np.testing.assert_array_equal(getattr(now, channel), getattr(clip, channel)[t], err_msg=channel)


def test_soft_goes_to_hard():
    frames = clips.noise(0, (12, 5, 7))
    hard, differences = model(N_sp=2)(frames, 30.0), []
    for temperature in (1.0, 0.1, 0.01, 1e-4):
        soft = model(lgmd.Soft(temperature), N_sp=2)(frames, 30.0)
        differences.append(
            [np.abs(getattr(soft, it) - getattr(hard, it)).max() / np.ptp(getattr(hard, it)) for it in CHANNELS]
        )
    differences = np.array(differences)
    assert differences[0, 0] > 1e-3
    assert np.all(np.diff(differences, axis=0) <= 0)
    assert np.all(differences[-1] < 1e-6)
    np.testing.assert_array_equal(model(lgmd.StraightThrough(), N_sp=2)(frames, 30.0).spikes, hard.spikes)


def test_gradients_are_those_of_central_differences():
    frames, weights = clips.noise(0, (12, 5, 7)), np.random.default_rng(9).normal(size=(3, 12))

    def loss(parameters, frames):
        out = lgmd.YueRindLGMD1(parameters, lgmd.Soft(1.0))(frames, 30.0)
        return (weights * jnp.stack([out.smp, out.spikes, out.mp / 1e4])).sum()

    parameters, jitted = lgmd.YueRindParameters(**CROSSED), jax.jit(loss)
    of_parameters, of_frames = jax.grad(loss, argnums=(0, 1))(parameters, frames)
    for name in lgmd.symbols(lgmd.YueRindParameters):
        value = getattr(parameters, name)
        up, down = (dataclasses.replace(parameters, **{name: value * (1 + h)}) for h in (1e-5, -1e-5))
        numeric = (jitted(up, frames) - jitted(down, frames)) / (2e-5 * value)
        assert numeric != 0
        np.testing.assert_allclose(getattr(of_parameters, name), numeric, rtol=1e-5, err_msg=name)
    for place in ((0, 0, 0), (5, 2, 3), (9, 4, 6)):
        nudge = np.zeros_like(frames)
        nudge[place] = 1e-4
        numeric = (jitted(parameters, frames + nudge) - jitted(parameters, frames - nudge)) / 2e-4
        np.testing.assert_allclose(of_frames[place], numeric, rtol=1e-5)


def test_the_gradient_of_a_still_clip_is_finite():
    gradient = jax.grad(lambda it: lgmd.YueRindLGMD1(it, lgmd.Soft())(np.full((5, 4, 4), 99.0), 30.0).smp.sum())
    assert all(np.isfinite(leaf) for leaf in jax.tree.leaves(gradient(lgmd.YueRindParameters(T_de=0.0))))


def test_a_batch_equals_single_clips_and_rests_where_nothing_moves():
    batch = np.stack([clips.noise(seed, (6, 5, 7)) for seed in range(3)] + [np.full((6, 5, 7), 80.0)])
    together = jax.vmap(model(), in_axes=(0, None))(batch, 30.0)
    for i, clip in enumerate(batch):
        for channel in CHANNELS:
            single = getattr(model()(clip, 30.0), channel)
            np.testing.assert_allclose(getattr(together, channel)[i], single, rtol=1e-12)
    assert np.all(together.mp[3] == 0)
    assert np.all(together.smp[3] == 0.5)
    assert not together.spikes[3].any()


def test_compiles_once_for_a_shape():
    traces = []

    def record(layers):
        traces.append(1)
        return layers.g.sum()

    for fps, W_I, temperature in ((30.0, 0.3, 1.0), (25, 1, 0.5), (np.float32(60), 0.2, 2)):
        network = lgmd.YueRindLGMD1(lgmd.YueRindParameters(W_I=W_I), lgmd.Soft(temperature))
        network(clips.noise(0, (5, 4, 4)), fps, record=record)
    assert len(traces) <= 2  # lax.scan itself may look at its body twice


# What it does, beside the LGMD2


def moving(stimulus) -> np.ndarray:
    """The frames in which the picture changes."""
    return 1 + np.flatnonzero(np.abs(np.diff(stimulus.frames, axis=0)).max(axis=(1, 2)) > 1e-6)


def square(shade) -> dict[str, Any]:
    levels = (10, 214) if shade == "dark" else (214, 10)
    return {"shape": "square", "level": levels[0], "background": levels[1]}


@pytest.mark.parametrize("shade", ["dark", "light"])
@pytest.mark.parametrize("comes", [True, False], ids=["approach", "recession"])
def test_every_movement_in_depth_is_answered_alike(shade, comes):
    """The paper's squares, a quarter as large. The LGMD2 is at rest in dark recession and light approach."""
    family = lgmd.stimuli.looming if comes else lgmd.stimuli.receding
    start, stop = (0.6, 27.5) if comes else (27.5, 0.6)
    grows = {"growth_px": 7.5, "acceleration_px": 90, "start_radius_px": start, "stop_radius_px": stop}
    stimulus = family(EYE, **grows, **square(shade))
    lgmd1, lgmd2 = (it(stimulus.frames, 30.0) for it in (lgmd.YueRindLGMD1(), lgmd.LGMD2()))
    assert np.mean(np.asarray(lgmd1.smp)[moving(stimulus)] > 0.86) > 0.6
    assert lgmd1.collision.any()
    assert (lgmd2.smp_adapted.max() > 0.9) == (comes == (shade == "dark"))
    assert (lgmd2.smp_adapted.max() > 0.9) or (lgmd2.smp_adapted.max() <= 0.505)


@pytest.mark.parametrize("shade", ["dark", "light"])
def test_translation_is_answered_to_its_end(shade):
    """Two pixels a frame, both ways alike; the LGMD2 answers its beginning alone."""
    responses = []
    for direction in (0, 180):
        path: dict[str, Any] = {"speed_px": 60, "size_px": 20, "start_px": -30, "stop_px": 30, "direction": direction}
        stimulus = lgmd.stimuli.translating(EYE, **path, **square(shade))
        lgmd1, lgmd2 = (it(stimulus.frames, 30.0) for it in (lgmd.YueRindLGMD1(), lgmd.LGMD2()))
        frames = moving(stimulus)
        assert np.asarray(lgmd1.smp)[frames].min() > 0.95
        assert np.asarray(lgmd1.spikes)[frames].all()
        assert np.asarray(lgmd2.smp_adapted)[frames[14] :].max() < 0.55
        responses.append(lgmd1.smp)
    np.testing.assert_allclose(*responses, atol=1e-9)


def test_inhibition_forbids_spikes_and_leaves_the_potential():
    """A step of the whole field by 12 levels passes T = 10.2 one frame late, a step by 9 does not."""
    for size, forbidden in ((9.0, False), (12.0, True)):
        frames = np.full((10, 6, 8), 100.0)
        frames[5:] += size
        frames[6, :3], frames[6, 3:] = 20.0, 200.0  # an edge in the frame that it forbids
        response = lgmd.YueRindLGMD1()(frames, 30.0)
        np.testing.assert_allclose(response.ffi[:7], [0] * 6 + [size])
        assert response.smp[6] > 0.99
        assert response.spikes[6] == (not forbidden)
        free = lgmd.ablate(lgmd.YueRindLGMD1(), "ffi")(frames, 30.0)
        assert free.spikes[6] == 1
        np.testing.assert_array_equal(free.smp, response.smp)


def test_a_tie_with_the_threshold_forbids():
    frames = np.full((6, 5, 5), 100.0)
    frames[3:] += 10.0
    frames[4, :2] += 100.0
    for T_ffi, spike in ((10.0, 0), (10.0 + 1e-9, 1)):
        network = lgmd.YueRindLGMD1(lgmd.YueRindParameters(T_ffi=T_ffi, alpha_ffi=0.0))
        response = network(frames, 30.0)
        assert (response.ffi[4], response.spikes[4]) == (10.0, spike)


@pytest.mark.parametrize("N_sp", [1, 4])
def test_an_alarm_takes_successive_spikes(N_sp):
    """A bar that moves in all frames but one."""
    frames = np.full((16, 12, 20), 200.0)
    for t, col in enumerate([0, 1, 2, 3, 3, 3, *range(4, 14)]):
        frames[t, 2:10, col : col + 3] = 20.0
    network = lgmd.YueRindLGMD1(lgmd.YueRindParameters(T_ffi=100.0), N_sp=N_sp)
    response = network(frames, 30.0)
    spikes = np.asarray(response.spikes)
    assert set(spikes) == {0.0, 1.0}
    run = 0
    for spike, alarm in zip(spikes, np.asarray(response.collision), strict=True):
        run = run + 1 if spike else 0
        assert alarm == (run >= N_sp)
    assert 0 < response.collision.sum() < spikes.sum() or N_sp == 1
