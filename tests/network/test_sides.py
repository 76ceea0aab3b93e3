"""MP and F by thirds of the field: against loops over pixels, in JAX and in the robot's program, and what they mean."""

import dataclasses

import jax
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax import hard
from tests import clips, oracle
from tests.network.test_mechanisms import (
    INTERVALS,
    PARAMETERS as WITH_MECHANISMS,
    as_hard,
    values as values_with_mechanisms,
)
from tests.network.test_network import SETS, values

PARAMETERS = lgmd.Parameters(**SETS["all"])
WIDTHS = (3, 4, 5, 9)  # each remainder by three, and the smallest


def assert_sides(pair, expected):
    for found, name in zip(pair, oracle.SIDES, strict=True):
        wanted = np.array(expected[name])
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-10 * np.abs(wanted).max(), err_msg=name)


@pytest.mark.parametrize("cols", WIDTHS)
def test_agree_with_loops_over_pixels(cols):
    frames = clips.noise(cols, (6, 4, cols))
    expected = oracle.respond(frames.tolist(), 30.0, values(PARAMETERS), n_p=1)
    recorded = lgmd.LGMD2(PARAMETERS, n_p=1)(frames, 30.0, record=lgmd.sides).recorded
    assert recorded.mp.shape == recorded.f.shape == (6, 3)
    assert_sides(recorded, expected)
    in_numpy = hard.HardLGMD2(values(PARAMETERS), 30.0, n_p=1)(frames)
    assert_sides((in_numpy.mp_sides, in_numpy.f_sides), expected)


def test_agree_where_inhibition_codes_size_and_the_cell_lags():
    mechanisms = ("size", "shunt", "lag")
    frames, intervals = clips.patchy(0, (len(INTERVALS), 5, 8)), INTERVALS
    model = lgmd.LGMD2(WITH_MECHANISMS, mechanisms=mechanisms)
    clock = {"intervals": intervals.tolist(), "mechanisms": mechanisms}
    expected = oracle.respond(frames.tolist(), None, values_with_mechanisms(), **clock)
    assert_sides(model(frames, interval=intervals, record=lgmd.sides).recorded, expected)
    program = as_hard(values_with_mechanisms(), mechanisms)
    now = hard.Response.over_time(map(program.step, frames, intervals))
    assert_sides((now.mp_sides, now.f_sides), expected)
    assert np.max(expected["f_sides"]) < 1


@pytest.mark.parametrize("model", [lgmd.LGMD2(PARAMETERS), lgmd.YueRindLGMD1()], ids=lambda model: type(model).__name__)
def test_they_add_up_to_the_whole_and_a_mirror_swaps_them(model):
    frames = clips.noise(3, (8, 6, 11))
    response = model(frames, 30.0, record=lgmd.sides)
    np.testing.assert_allclose(response.recorded.mp.sum(axis=1), response.mp, rtol=1e-12)
    sums, _ = model.sums(jax.numpy.asarray(frames), jax.numpy.asarray(1000 / 30))
    np.testing.assert_allclose(response.recorded.f.sum(axis=1), sums.f, rtol=1e-12)
    mirrored = model(frames[:, :, ::-1], 30.0, record=lgmd.sides).recorded
    np.testing.assert_allclose(mirrored.mp[:, ::-1], response.recorded.mp, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(mirrored.f[:, ::-1], response.recorded.f, rtol=1e-12)


def test_they_tell_on_which_side_something_moves():
    frames = np.full((4, 6, 12), 200.0)
    frames[1:, 2:4, 9:11] = 40.0
    now = lgmd.LGMD2()(frames, 30.0, record=lgmd.sides).recorded
    assert now.mp[1, 2] > 0
    assert now.f[1, 2] > 0
    np.testing.assert_array_equal(now.mp[1, :2], 0)
    np.testing.assert_array_equal(now.f[1, :2], 0)


def test_a_stream_has_them():
    frames, model = clips.noise(4, (6, 4, 4)), lgmd.LGMD2(PARAMETERS, n_p=1)
    clip = model(frames, 30.0, record=lgmd.sides).recorded
    state = model.init(frames[0])
    for t, frame in enumerate(frames):
        state, now = model.step(state, frame, 30.0, record=lgmd.sides)
        np.testing.assert_allclose(now.recorded.mp, clip.mp[t], rtol=1e-12, atol=1e-9)


def test_layers_without_the_maps_are_refused():
    @dataclasses.dataclass
    class Bare:
        mp: int = 0

    with pytest.raises(ValueError, match="Bare has no maps mp and f; give them to the layers of your network"):
        lgmd.sides(Bare())
