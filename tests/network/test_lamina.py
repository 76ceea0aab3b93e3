"""The lamina: P does not depend on how often the scene is looked at, nor does what is computed of it."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from tests import clips

SCENE = clips.noise(5, (7, 4, 5))  # luminance at every tenth of a second, on a line in between
EVERY_TENTH = 100.0 * np.arange(len(SCENE))


def model(tau: float = 100.0, mechanisms=("lamina",), **changes) -> lgmd.LGMD2:
    return lgmd.LGMD2(lgmd.Parameters(tau_lamina=tau, **changes), mechanisms=mechanisms)


def seen(time) -> np.ndarray:
    """The scene at these moments, in ms."""
    return np.apply_along_axis(lambda levels: np.interp(time, EVERY_TENTH, levels), 0, SCENE)


def at_the_tenths(network, time, record=lambda layers: layers.p):
    """P and F at every tenth of a second, of which all are among the frames."""
    response = network(seen(time), interval=np.diff(time, prepend=time[0] - 20.0), record=record)
    tenths = np.searchsorted(time, EVERY_TENTH)
    np.testing.assert_array_equal(time[tenths], EVERY_TENTH)
    sums, _ = network.sums(jnp.asarray(seen(time)), jnp.asarray(np.diff(time, prepend=time[0] - 20.0)))
    return np.asarray(response.recorded)[tenths], np.asarray(sums.f)[tenths]


def steady(fps: float) -> np.ndarray:
    return np.round(np.arange(round(0.6 * fps) + 1) * 1000 / fps, 9)


def uneven() -> np.ndarray:
    between = np.random.default_rng(0).uniform(0, EVERY_TENTH[-1], 40)
    return np.sort(np.concatenate([EVERY_TENTH, between]))


@pytest.mark.parametrize("tau", [20.0, 100.0, 400.0])
def test_ramps_give_the_same_at_any_frame_rate(tau):
    """To rounding, where luminance goes on a line between moments that all clocks share."""
    p, f = at_the_tenths(model(tau), EVERY_TENTH)  # 10 fps
    assert np.abs(p[1:]).max() > 20
    for time in (steady(20.0), steady(30.0), steady(60.0), uneven()):
        there, f_there = at_the_tenths(model(tau), time)
        np.testing.assert_allclose(there, p, rtol=0, atol=1e-11 * np.abs(p).max())
        np.testing.assert_allclose(f_there, f, rtol=0, atol=1e-11 * f.max())
    plain, _ = at_the_tenths(lgmd.LGMD2(), EVERY_TENTH)
    often, _ = at_the_tenths(lgmd.LGMD2(), steady(60.0))
    assert np.abs(often - plain).max() > np.abs(plain).max() / 2


def test_it_solves_its_equation():
    """dP/dt = dL/dt - P/tau by ten thousand small steps of a ramp of 40 grey levels in 100 ms, and a rest of 300."""
    dt, p, course = 0.04, 0.0, []
    for i in range(10_000):
        p += dt * ((0.4 if i * dt < 100 else 0.0) - p / 70)
        course.append(p)
    frames = 100 + np.minimum(0.4 * np.arange(0, 401, 20.0), 40)[:, None, None] * np.ones((3, 4))
    found = model(70.0)(frames, 50.0, record=lambda layers: layers.p[1, 2]).recorded
    np.testing.assert_allclose(found[1:], np.array(course)[499::500], rtol=2e-3)


@pytest.mark.parametrize("time", [steady(30.0), uneven()], ids=["steady", "uneven"])
def test_limits(time):
    """A lamina that never rests keeps the whole change since the first frame; one that rests at once tells speed."""
    slow, _ = at_the_tenths(model(1e12), time)
    np.testing.assert_allclose(slow, SCENE - SCENE[0], rtol=0, atol=1e-6)
    fast, _ = at_the_tenths(model(1e-4), time)
    per_ms = np.diff(SCENE, axis=0) / 100
    np.testing.assert_allclose(fast[1:], 1e-4 * per_ms, rtol=1e-9, atol=1e-13)
    assert not np.any(fast[0])


def test_a_long_time_constant_sees_a_step_as_the_plain_network_does():
    """In the frame of the step; only after it the change is still there."""
    frames = np.full((4, 3, 3), 50.0)
    frames[2:] = 90.0
    p = model(1e12)(frames, 30.0, record=lambda layers: layers.p).recorded
    plain = lgmd.LGMD2()(frames, 30.0, record=lambda layers: layers.p).recorded
    np.testing.assert_allclose(p[:3], plain[:3], atol=1e-6)
    np.testing.assert_allclose(p[3], 40.0, atol=1e-6)
    np.testing.assert_array_equal(plain[3], 0.0)


def test_size_coding_compares_with_the_height_that_delayed_flows_reach():
    """A step of which D reaches T_p a little later counts at any frame rate, and one that does not never does."""
    tau1, tau = 20.0, 100.0
    ratio = tau1 / tau
    # D of a step of 1: (exp(-t/tau) - exp(-t/tau1))/(1 - tau1/tau), which has its maximum here.
    highest = ratio ** (ratio / (1 - ratio))
    for fps in (100.0, 400.0):
        shares = []
        for height in (0.85, 1.1):
            frames = np.full((round(0.2 * fps), 3, 4), 100.0)
            frames[3:, 1, 1] += height * 19.0 / highest
            own = model(tau, ("size", "lamina"), tau1=tau1, sigma1=0.0, T_p=19.0)
            exact = dataclasses.replace(own, low_pass="exact")
            held = exact(frames, fps, record=lambda layers: layers.f).recorded
            assert not np.any(np.delete(np.asarray(held).reshape(len(frames), -1), 5, axis=1))
            shares.append(np.asarray(held)[:, 1, 1].max())
        assert shares == [0.0, 1.0]


@pytest.mark.parametrize("mechanisms", [("size",), ()], ids=str)
def test_noise_does_not_add_up(mechanisms):
    """It inhibits about as much at every rate, where without a lamina it fills the field at high ones."""
    shares = [
        lgmd.inhibition_in_noise(model(100.0, (*mechanisms, "lamina")), 16.0, fps) for fps in (30.0, 100.0, 200.0)
    ]
    assert shares[0] > 1
    assert max(shares) < 1.25 * min(shares)


@pytest.mark.parametrize(("mechanisms", "least", "most"), [((), 1.0, np.inf), (("lamina",), 0.0, 0.15)], ids=str)
def test_a_loom_drives_as_much_at_every_frame_rate(mechanisms, least, most):
    """MP of one object, of which the plain network sees several times as much in a longer frame."""
    eye = lgmd.Eye(rows=24, cols=32, degrees_per_pixel=3.0, fps=60.0)
    own = dataclasses.replace(model(100.0, mechanisms, sigma1=0.0, T_s=8.0), low_pass="exact", eye=eye)
    courses = []
    for fps in (10.0, 20.0, 60.0):
        there = lgmd.at_frame_rate(own, fps)
        loom = lgmd.stimuli.looming(dataclasses.replace(eye, fps=fps), l_over_v=40.0, stop_angle=60.0)
        courses.append(np.interp(np.arange(-1000.0, 1.0, 100.0), loom.time, there(loom.frames).mp))
    for coarse in courses[:2]:
        assert least < np.abs(coarse - courses[2]).max() / courses[2].max() < most


def test_thresholds_of_changes_stay_at_another_frame_rate():
    values = {"T_s": 3.0, "T_ffi": 20.0, "k": 0.3, "T_sfa": 3e-4, "sigma1": 0.5, "N_sp": 6.0}
    eye = lgmd.Eye(rows=12, cols=16, degrees_per_pixel=6.0, fps=100.0)
    network = dataclasses.replace(model(80.0, **values), eye=eye, N_ts=9)
    other = lgmd.at_frame_rate(network, 50.0)
    found = {name: float(getattr(other.parameters, name)) for name in (*values, "tau_lamina")}
    per_frame = {"T_sfa": 6e-4, "sigma1": 0.25, "N_sp": 3.0}
    assert found == pytest.approx({**values, **per_frame, "tau_lamina": 80.0})
    assert other.N_ts == 4
    wider = lgmd.at_eye(network, dataclasses.replace(eye, rows=24, fps=50.0))
    assert float(wider.parameters.k) < 0.3


@pytest.mark.parametrize("mechanisms", [("lamina",), ("size", "lamina")], ids=str)
@pytest.mark.parametrize("clock", ["steady", "uneven"])
def test_slopes_by_the_time_constant_are_differences(mechanisms, clock):
    """Of MP and F; forward and backward alike."""
    frames = jnp.asarray(clips.patchy(33, (14, 5, 7)))
    interval = jnp.asarray(40.0 if clock == "steady" else np.random.default_rng(1).uniform(15, 60, len(frames)))
    changes = {"theta1": 0.4, "theta3": 0.002, "sigma1": 0.3, "T_p": 50.0, "T_s": 12.0}

    def sums(tau):
        network = model(tau, mechanisms, **changes)
        network = dataclasses.replace(network, thresholds=lgmd.Soft(1.0))
        return jnp.stack(network.sums(frames, interval)[0])

    run, tau, step = jax.jit(sums), jnp.asarray(60.0), 1e-3
    coarse, fine = ((run(tau + by) - run(tau - by)) / (2 * by) for by in (step, step / 2))
    expected = np.asarray((4 * fine - coarse) / 3)
    largest = np.abs(expected).max(axis=1, keepdims=True)
    assert np.all(largest > 1e-4)
    forward = np.asarray(jax.jacfwd(sums)(tau))
    assert np.all(np.abs(forward - expected) < 1e-6 * largest)
    np.testing.assert_allclose(jax.jacrev(sums)(tau), forward, rtol=0, atol=1e-11 * largest.max())
