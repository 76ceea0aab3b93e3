"""The benchmark: its clock, its count of kernels, and that the peers compute the network that they are compared on."""

import itertools
import pathlib

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize
import xarray

import lgmd2jax as lgmd
from benchmarks import _kernels, _library, _peers, _profile, _traffic, paper_sentences, threshold_angle
from benchmarks._evolution import Evolution, outside
from benchmarks._task import FPS, PARAMETERS, VALUES, Size, film
from benchmarks._timing import time_together
from lgmd2jax.fitting._problem import problem_of
from lgmd2jax.hard import HardLGMD2

FRAMES = film(Size(25, 31), 60)
BENCHMARKS = sorted((pathlib.Path(__file__).parents[1] / "benchmarks").glob("[a-z]*.py"))


def peer(module):
    found = _peers.find(module)
    return found if found else pytest.skip(f"{_peers.PACKAGES[module]} is not installed")


@pytest.mark.parametrize("path", BENCHMARKS, ids=lambda path: path.stem)
def test_help_says_what_a_benchmark_shows_and_how_it_is_run(path):
    text = path.read_text(encoding="utf-8")
    assert "ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter" in text
    assert f"python -m benchmarks.{path.stem}" in text.split('"""')[1]


def test_the_film_passes_every_threshold_in_both_directions():
    response = HardLGMD2(PARAMETERS, FPS)(FRAMES)
    assert set(response.spikes) == {0, 1, 2}
    assert set(response.collision) == {False, True}
    assert len(np.unique(response.ffi > VALUES.T_ffi)) == 2


@pytest.mark.parametrize("module", _peers.PACKAGES)
def test_peers_compute_the_network(module):
    _peers.check(module, peer(module).respond)


def test_a_peer_that_computes_something_else_is_refused():
    def respond(frames, values, fps):
        return HardLGMD2({**PARAMETERS, "w_bias": 0.31}, fps)(frames)

    with pytest.raises(ValueError, match="mp of frame"):
        _peers.check("a peer", respond)


def test_the_numba_loop_over_a_batch():
    loop = peer("_numba_loop")
    films = np.stack([FRAMES, FRAMES[:, ::-1].copy()])
    batch = loop.respond_batch(films, VALUES, FPS)
    for found, frames in zip(batch, films, strict=True):
        np.testing.assert_equal(found, loop.respond(frames, VALUES, FPS))


@pytest.mark.slow
def test_the_gradient_of_pytorch():
    found = peer("_torch").gradient(FRAMES, VALUES, FPS)
    # In single precision like PyTorch: there the slope by T_sfa, which U(t) - U(t-1) is compared with, is 1 % off.
    parameters = lgmd.Parameters(**VALUES._asdict())
    expected = jax.grad(lambda p: lgmd.LGMD2(p, lgmd.Soft())(FRAMES, FPS).smp_adapted.sum())(parameters)
    assert {"theta1", "theta2", "theta3", "tau1", "sigma1", "w_bias", "T_s", "tau2", "T_ffi"} <= set(found)
    for name in lgmd.symbols():
        np.testing.assert_allclose(found.get(name, 0.0), getattr(expected, name), rtol=1e-4, err_msg=name)


def test_ratios_are_those_of_each_round():
    now, load = [0.0], itertools.cycle([1.0, 5.0, 2.0])

    def lasting(seconds):
        def call():
            now[0] += seconds * burden[0]

        return call

    burden = [1.0]

    def third_subject():
        burden[0] = next(load)  # the machine is disturbed from one round to the next

    timings = time_together(
        {"disturbance": third_subject, "slow": lasting(0.3), "fast": lasting(0.1)},
        rounds=6,
        at_least=0.0,
        clock=lambda: now[0],
    )
    assert timings["slow"].over(timings["fast"]) == pytest.approx(3.0)
    assert max(timings["fast"].rounds) / min(timings["fast"].rounds) == pytest.approx(5.0)


def test_compilation_is_told_apart_and_short_calls_are_repeated():
    now, calls = [0.0], [0]

    def call():
        calls[0] += 1
        now[0] += 2.25 if calls[0] == 1 else 0.25

    timing = time_together({"it": call}, rounds=3, at_least=1.0, clock=lambda: now[0])["it"]
    assert timing.compile == 2.0
    assert timing.median == 0.25
    assert calls[0] == 2 + 3 * 4


def test_kernels_are_those_of_the_pixel_loop():
    loop = """
  %state = (s32[], f32[3,3]{1,0}) parameter(0)
  %map = f32[3,3]{1,0} get-tuple-element(%state), index=1
  %moved.1 = f32[3,3]{1,0} fusion(%map), kind=kLoop, calls=%computation
  %copy.2 = f32[3,3]{1,0} copy(%map)
  ROOT %next = (s32[], f32[3,3]{1,0}) tuple(%map, %moved.1)"""
    assert _kernels.count_instructions(loop) == {"copy": 1, "fusion": 1}


def test_bytes_are_those_that_a_step_reads_and_writes():
    """A map that is scaled where it lies, and another of which a row is written into it."""

    def loop(maps, films):
        def step(maps, film):
            scaled, written = maps
            return (1.5 * scaled, written.at[3].set(film[2] + film[4])), None

        return jax.lax.scan(step, maps, films)[0]

    x, films = jnp.zeros((64, 33), jnp.float32), jnp.ones((9, 64, 33), jnp.float32)
    text = jax.jit(loop).lower((x, x), films).compile().as_text()
    assert text is not None
    found = _traffic.bytes_of_step(text, _traffic.body_of_loop(text, "f32[64,33]"))
    assert 0 < found - 2 * x.nbytes - x[3].nbytes < 100  # for indices


def test_a_profile_ends_with_what_is_profiled():
    """The parts of each add bytes, and the last program is the whole: its result is that of the library."""
    with jax.enable_x64(False):
        check_profiles(Size(26, 31))


def check_profiles(size):
    profiled = _profile.programs(size) | {"sweep": _profile.sweep_programs(side=2)}
    for what, parts in profiled.items():
        traffic = [program.bytes for program in parts.values()]
        assert traffic == sorted(traffic), what
        assert traffic[0] > 0, what
    last = {what: list(parts.values())[-1].call() for what, parts in profiled.items()}
    frames = jnp.asarray(film(size, _profile.FRAMES))
    model, interval = lgmd.LGMD2(lgmd.Parameters(**PARAMETERS)), jnp.asarray(1000 / FPS)
    _, ((f,), (mp,)) = last["hard response"]
    assert_close((mp, f), model.sums(frames, interval)[0])
    jacobian, sums = list(profiled["gradient"].values())[-2].call()
    assert_close(sums, lgmd.LGMD2(lgmd.Parameters(**PARAMETERS), lgmd.Soft()).sums(frames, interval)[0])
    freed = [name for names in _profile.FREE.values() for name in names]
    for found, whole in zip(jacobian, _library.jacobian()(frames), strict=True):
        assert_close(found, {name: getattr(whole, name) for name in freed})
    assert_close(last["gradient"], _library.gradient()(frames))
    np.testing.assert_allclose(last["sweep"], _library.sweep(2, 2)(), rtol=1e-4)


def assert_close(found, expected):
    """In single precision."""
    for leaf, other in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(leaf, other, rtol=0, atol=1e-3 * np.abs(other).max())


def test_the_threshold_angle_of_a_cell_that_obeys_the_law_is_one():
    """Peaks 4.4 l/|v| - 35 ms before the collision: 35 are the allowance, so the angle is 2 atan(1/4.4)."""
    time = np.arange(-500, 41) * 10.0
    moment = 35 - 4.4 * threshold_angle.L_OVER_V
    course = np.exp(-(((time - moment[:, None]) / 40) ** 2) / 2)
    axes = {"contrast": threshold_angle.CONTRASTS, "l_over_v": threshold_angle.L_OVER_V, "time": time}
    responses = xarray.DataArray(0.3 * np.tile(course, (len(threshold_angle.CONTRASTS), 1, 1)), axes)
    surfaces = threshold_angle.surfaces_of(responses, threshold_angle.reference_of(responses))
    np.testing.assert_allclose(surfaces.angle, 2 * np.degrees(np.arctan(1 / 4.4)), atol=0.3)
    np.testing.assert_allclose(surfaces.peak, 1, atol=0.01)
    np.testing.assert_allclose(surfaces.fall, 40 * np.sqrt(2 * np.log(2)), atol=2)
    assert threshold_angle.most_within(surfaces.angle, 1.0) == 1


def test_the_largest_share_within_a_window():
    assert threshold_angle.most_within(np.array([[0.0, 10.0], [11.0, 14.9]]), 5.0) == 0.75


def test_the_share_of_a_sentence_is_that_of_its_samples_within_the_band():
    """Two stimuli, one of them shorter; one sentence on both, the other on frames 4 to 8 of the second alone."""
    stimuli = [
        lgmd.stimuli.Stimulus(jnp.asarray(FRAMES[:count], dtype=float), FPS, jnp.arange(count) * 1000 / FPS)
        for count in (30, 20)
    ]
    model = lgmd.LGMD2(lgmd.Parameters(**VALUES._asdict()), eye=lgmd.Eye(25, 31, 1.0, FPS))
    curves = [HardLGMD2(PARAMETERS, FPS)(FRAMES[:count]).smp for count in (30, 20)]
    both, part = np.concatenate(curves), curves[1][4:9]
    values = np.unique(both)
    low, high = values[1:3].mean(), values[-3:-1].mean()  # between two values, so that rounding decides nothing
    some = 4000 / FPS - 1, 8000 / FPS + 1
    first = lgmd.Band(low=float(low), high=float(high), channel="smp", quote="both")
    second = lgmd.Band(segments_ms=[some], low=float(part.max()) + 0.01, high=1.0, channel="smp", quote="part")
    pairs = [(stimuli[0], [first.on(stimuli[0])]), (stimuli[1], [first.on(stimuli[1]), second.on(stimuli[1])])]
    problem = problem_of(model, lgmd.Observation(), lgmd.Free(w_bias=None, T_sp=None), pairs, "squares")
    own = problem.free.place(model.parameters, lgmd.Observation())
    kept = paper_sentences.kept_by(
        problem,
        paper_sentences.sentences_of(problem, pairs),
        jnp.asarray(own),
        jnp.asarray(own[None, list(problem.cell_indices)]),
    )
    expected = np.mean((low <= both) & (both <= high)), 0.0
    np.testing.assert_allclose(kept.share[0], expected, atol=1e-9)
    outside = np.maximum(low - both, both - high).max(), part.max() + 0.01 - part.min()
    np.testing.assert_allclose(kept.farthest[0], outside, atol=1e-6)


def test_an_evolution_finds_the_least_value_in_the_box():
    rng, size = np.random.default_rng(0), 8
    mix, goal = rng.standard_normal((size, size)), np.where(np.arange(size) == 2, 1.3, 0.4)
    form = mix @ mix.T + 0.05 * np.eye(size)

    def value(points):
        off = np.clip(points, 0, 1) - goal
        return np.einsum("...i,ij,...j", off, form, off)

    evolution = Evolution(np.full(size, 0.6), 0.2, np.array([1, 4, 5]), variants=16, seed=1)
    for _ in range(150):
        points = evolution.ask()
        assert np.ptp(points[..., evolution.dear], axis=1).max() == 0
        values = value(points) + outside(points)
        each, best = np.arange(len(points)), values.argmin(axis=1)
        evolution.tell(points[each, best], values[each, best])
    least = scipy.optimize.minimize(value, np.full(size, 0.5), bounds=[(0, 1)] * size)
    assert least.x[2] == 1
    assert value(evolution.mean) == pytest.approx(least.fun, rel=1e-3)
