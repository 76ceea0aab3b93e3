"""Habituation: what excited of late excites less, what did not as before, and it passes."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from tests.network.test_mechanisms import FRAMES, streamed


def model(mechanisms=("habituation",), **values) -> lgmd.LGMD2:
    # An S that is what the pixel's neighbours lose, at once: without a threshold, inhibition or memory.
    plain = {"sigma1": 0.0, "w_bias": 0.0, "T_s": 0.0, "tau1": 1e-6, "theta1": 0.0}
    return lgmd.LGMD2(lgmd.Parameters(**plain | values), mechanisms=mechanisms)


def mp(network: lgmd.LGMD2, frames=FRAMES, interval: float = 20.0) -> np.ndarray:
    return np.asarray(network(frames, interval=np.full(len(frames), interval)).mp)


def blinks(times: list[int], count: int, depth: float = 60.0) -> np.ndarray:
    """A field that is darker by `depth` in these frames."""
    frames = np.full((count, 6, 6), 150.0)
    frames[times] -= depth
    return frames


def test_without_effect_where_s_hab_is_large():
    values = {"theta1": 0.4, "sigma1": 0.1, "w_bias": 0.3, "tau1": 20.0}
    np.testing.assert_allclose(mp(model(S_hab=1e12, **values)), mp(model((), **values)), rtol=1e-9)
    assert np.any(mp(model(S_hab=1.0, **values)) < 0.5 * mp(model((), **values)))


@pytest.mark.parametrize("pause", [2, 10, 50])
def test_the_answer_recovers_with_its_time_constant(pause):
    """A blink of depth d leaves B = a S, which then falls by exp(-t/tau); the first one finds nothing that divides."""
    tau, threshold, depth, interval = 200.0, 5.0, 60.0, 20.0
    frames = blinks([1, 1 + pause], 3 + pause, depth)
    network = dataclasses.replace(model(tau_hab=tau, S_hab=threshold), low_pass="exact")
    s, a = 1.5 * depth, -np.expm1(-interval / tau)  # W adds up to 1.5
    first, second = mp(network, frames)[[1, 1 + pause]] / 36
    assert first == pytest.approx(s, rel=1e-6)
    assert second == pytest.approx(s / (1 + a * s * np.exp(-(pause - 1) * interval / tau) / threshold), rel=1e-6)
    assert second < first * (0.5 if pause == 2 else 1)


def test_it_is_of_a_place():
    """What moves on and on over one place is answered less and less; the same that comes to another place is not."""
    frames = np.full((40, 9, 24), 150.0)
    for t in range(1, 40):
        at = slice(0, 12) if t < 36 else slice(12, 24)
        frames[t, :, at] = 150.0 - 80 * (t % 2)
    network = model(tau_hab=300.0, S_hab=10.0)
    darker = mp(network, frames)[1::2]
    assert np.all(np.diff(darker[:17]) < 0)
    assert darker[18] > 2 * darker[16]


def test_a_steady_flow_is_divided_by_what_it_is():
    """Of a field that darkens evenly x is left after a while, with x (1 + x/S_hab) = S: B is x then."""
    frames = np.broadcast_to(250 - 2.0 * np.arange(100)[:, None, None], (100, 5, 5))
    network = model(tau_hab=60.0, S_hab=8.0)
    left = mp(network, frames)[-1] / 25
    assert left * (1 + left / 8) == pytest.approx(3.0, rel=1e-6)


def test_behind_a_lamina_the_frame_rate_plays_a_small_part():
    """The largest MP of a square that grows, at 15, 60 and 240 frames a second."""
    behind, without = [], []
    for fps in (15, 60, 240):
        time = np.arange(0, 1, 1 / fps)
        away = np.abs(np.arange(64) - 31.5)
        covered = np.clip((4 + 20 * time**2)[:, None] - away + 0.5, 0, 1)
        frames = 200 - 150 * covered[:, :, None] * covered[:, None, :]
        values = {"tau_lamina": 40.0, "tau1": 30.0, "tau_hab": 300.0, "S_hab": 5.0}
        behind.append(mp(model(("lamina", "habituation"), **values), frames, 1000 / fps).max())
        without.append(mp(model(**values), frames, 1000 / fps).max())
    assert behind == pytest.approx(np.full(3, behind[1]), rel=0.07)
    assert without[0] > 5 * without[2]


def test_at_another_frame_rate():
    """S_hab is compared with changes in a frame; with a lamina with changes in a time, and stays."""
    eye = lgmd.Eye(rows=5, cols=7, degrees_per_pixel=2.0, fps=30.0)
    for mechanisms, expected in ((("habituation",), 5.0), (("lamina", "habituation"), 10.0)):
        own = dataclasses.replace(model(mechanisms, S_hab=10.0, tau_hab=300.0), eye=eye)
        other = lgmd.at_frame_rate(own, 60.0).parameters
        assert (float(other.S_hab), float(other.tau_hab)) == pytest.approx((expected, 300.0))


@pytest.mark.parametrize("name", ["tau_hab", "S_hab"])
def test_values_out_of_the_domain_are_refused(name):
    with pytest.raises(ValueError, match=rf"{name} is 0 .*; it must lie in \(0, inf\)"):
        lgmd.Parameters(**{name: 0.0})


def test_what_is_recorded_as_s_is_what_the_threshold_sees():
    network = model(S_hab=10.0, T_s=4.0)
    recorded = network(FRAMES, 30.0, record=lambda layers: (layers.s, layers.s_gated)).recorded
    s, gated = map(np.asarray, recorded)
    np.testing.assert_array_equal(gated, np.where(s >= 4.0, s, 0.0))
    assert jnp.any((s > 0) & (s < 4.0))


def test_stepping_gives_what_the_scan_does():
    """To the rounding of sums that compilers order as they like."""
    network = model(("lamina", "habituation"), theta1=0.4, sigma1=0.1, w_bias=0.3, tau1=20.0, S_hab=3.0)
    whole, stepped = mp(network), streamed(network, FRAMES, np.full(len(FRAMES), 20.0))["mp"]
    np.testing.assert_allclose(stepped, whole, rtol=0, atol=1e-14 * whole.max())
