"""The forward sensitivities against plain differentiation of the same scan."""

import math
import re

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
import pytest

import lgmd2jax as lgmd
from lgmd2jax._types import cast
from tests import clips

PARAMETERS = lgmd.Parameters(theta1=0.4, theta2=1.3, theta3=0.02, T_s=15.0, T_ffi=46.0, k=60.0, u=0.7, sigma1=0.2)
FRAMES = jnp.asarray(clips.loom(3, (12, 7, 8)) + 3 * clips.noise(8, (12, 7, 8)) / 245)
INTERVAL = jnp.asarray(1000 / 30)
LOCAL = ("theta1", "theta2", "theta3", "w_bias", "T_s")
STRUCTURES = [{"n_p": n_p, "low_pass": form} for n_p in (0, 2) for form in ("backward_euler", "exact")]
THRESHOLDS = [lgmd.Soft(0.5), lgmd.StraightThrough(0.5)]


def exact(model, frames=FRAMES, interval=INTERVAL):
    return model.sums(frames, interval)[0]


def plain(model, frames=FRAMES, interval=INTERVAL):
    """The same numbers with the rule switched off."""
    parameters = cast(model.pixels.parameters, frames.dtype)
    pixels = eqx.tree_at(lambda stage: stage.parameters, model.pixels, parameters)
    return pixels.plain(frames, interval)[0]


def of_parameters(potentials, thresholds=THRESHOLDS[0], **structure):
    return lambda parameters, *inputs: potentials(lgmd.LGMD2(parameters, thresholds, **structure), *inputs)


def with_value(name, value):
    return eqx.tree_at(lambda parameters: getattr(parameters, name), PARAMETERS, value)


def assert_close(found, expected, tolerance=1e-10):
    """Every leaf within `tolerance` of its own largest value; where nothing is expected there is exactly nothing."""
    leaves, expected_leaves = jax.tree.leaves_with_path(found), jax.tree.leaves(expected)
    assert len(leaves) == len(expected_leaves)
    for (path, leaf), other in zip(leaves, expected_leaves, strict=True):
        largest = np.max(np.abs(other), initial=0)
        np.testing.assert_allclose(leaf, other, rtol=0, atol=tolerance * largest, err_msg=jax.tree_util.keystr(path))


@pytest.mark.parametrize("structure", STRUCTURES, ids=str)
@pytest.mark.parametrize("thresholds", THRESHOLDS, ids=["soft", "straight-through"])
def test_equals_the_plain_jacobian(thresholds, structure):
    found = jax.jit(jax.jacfwd(of_parameters(exact, thresholds, **structure)))(PARAMETERS)
    expected = jax.jit(jax.jacfwd(of_parameters(plain, thresholds, **structure)))(PARAMETERS)
    assert_close(found, expected)
    mp, f = found
    moves_mp = {name for name in lgmd.symbols() if np.any(getattr(mp, name))}
    stateful = {"tau1", "sigma1"} | ({"u"} if structure["n_p"] else set())
    assert moves_mp == {*LOCAL, *stateful}
    assert {name for name in lgmd.symbols() if np.any(getattr(f, name))} == stateful & {"u"}


def test_hard_thresholds_have_no_slope_of_their_own():
    found = jax.jit(jax.jacfwd(of_parameters(exact, lgmd.Hard())))(PARAMETERS)
    assert_close(found, jax.jit(jax.jacfwd(of_parameters(plain, lgmd.Hard())))(PARAMETERS))
    assert np.any(found[0].theta2)
    assert not np.any(found[0].T_s)


def test_all_modes_agree():
    def loss(potentials):
        return lambda parameters: jnp.vdot(jnp.sin(jnp.arange(12.0)), of_parameters(potentials, n_p=1)(parameters)[0])

    expected = jax.jit(jax.grad(loss(plain)))(PARAMETERS)
    assert_close(jax.jit(jax.grad(loss(exact)))(PARAMETERS), expected)
    _, push = jax.linearize(loss(exact), PARAMETERS)
    along = jax.tree.map(lambda leaf: 0.1 * leaf, PARAMETERS)
    whole = sum(jax.tree.leaves(jax.tree.map(jnp.multiply, expected, along)))
    np.testing.assert_allclose(push(along), whole, rtol=1e-10)


@pytest.mark.parametrize("part", ["frames", "interval", "temperature", "widths"])
def test_what_else_is_perturbed_takes_the_plain_rule(part):
    def slope(potentials):
        def run(parameters, value):
            model, frames, interval = lgmd.LGMD2(parameters, THRESHOLDS[0]), FRAMES, INTERVAL
            if part == "frames":
                frames = value * frames
            elif part == "interval":
                interval = value * interval
            elif part == "temperature":
                model = lgmd.LGMD2(parameters, lgmd.Soft(0.5 * value))
            else:
                model = lgmd.LGMD2(parameters, lgmd.Soft(0.5, lgmd.Widths(s=0.1 * value)))
            return potentials(model, frames, interval)[0]

        return jax.jit(jax.jacfwd(run, argnums=(0, 1)))(PARAMETERS, jnp.asarray(1.0))

    found = slope(exact)
    assert_close(found, slope(plain))
    assert np.any(found[1])


@pytest.mark.slow
def test_with_record():
    def run(parameters, record=None):
        response = lgmd.LGMD2(parameters, THRESHOLDS[0])(FRAMES, 30.0, record=record)
        return response.mp, response.recorded

    mp, s = jax.jacfwd(lambda parameters: run(parameters, lambda layers: layers.s.sum()))(PARAMETERS)
    assert_close(mp, jax.jacfwd(run)(PARAMETERS)[0])
    # S is linear in theta2, with S_off as its slope.
    _, s_off = run(PARAMETERS, lambda layers: layers.s_off.sum())
    np.testing.assert_allclose(s.theta2, s_off, rtol=1e-10)


@pytest.mark.parametrize(
    "names", [("T_s", "tau1"), pytest.param((*LOCAL, "tau1", "sigma1", "u"), marks=pytest.mark.slow)], ids=len
)
def test_second_derivatives(names):
    def hessian(potentials):
        def loss(values):
            parameters = eqx.tree_at(lambda p: [getattr(p, name) for name in names], PARAMETERS, list(values))
            mp, f = of_parameters(potentials, n_p=1)(parameters)
            return jnp.vdot(jnp.cos(jnp.arange(12.0)), mp) + f.sum()

        return jax.jit(jax.hessian(loss))(jnp.stack([getattr(PARAMETERS, name) for name in names]))

    found, expected = hessian(exact), hessian(plain)
    assert_close(list(found), list(expected), 1e-9)
    assert_close(found, found.T)


def item(tree, i):
    return jax.tree.map(lambda leaf: leaf[i], tree)


BATCH = jnp.stack([jnp.asarray(clips.loom(seed, (8, 5, 6))) for seed in range(3)])


def test_under_vmap():
    """Of each of two sets with a clip of its own, and of one set over both clips."""
    batch, slope = BATCH[:2], jax.jacfwd(of_parameters(exact))
    sets = jax.vmap(lambda tau1: lgmd.Parameters(theta2=1.3, tau1=tau1))(jnp.array([10.0, 40.0]))
    together = jax.jit(jax.vmap(slope))(sets, batch)
    over_clips = jax.jit(jax.vmap(slope, in_axes=(None, 0)))(PARAMETERS, batch)
    plainly = jax.jit(jax.jacfwd(of_parameters(plain)))
    for i, frames in enumerate(batch):
        assert_close(item(together, i), plainly(item(sets, i), frames))
        assert_close(item(over_clips, i), plainly(PARAMETERS, frames))


@pytest.mark.slow
def test_over_stimuli_and_parameter_sets():
    slope = jax.jacfwd(of_parameters(exact, n_p=1))
    sets = jax.vmap(lambda theta2, tau1: lgmd.Parameters(theta2=theta2, tau1=tau1))(
        jnp.array([1.0, 2.0, 3.0]), jnp.array([10.0, 20.0, 40.0])
    )
    together = jax.jit(jax.vmap(slope))(sets, BATCH)
    mapped = jax.jit(lambda sets, batch: jax.lax.map(lambda pair: slope(*pair), (sets, batch)))(sets, BATCH)
    # Differentiated from outside, as a fit over its conditions does.
    outside = jax.jit(
        jax.jacfwd(
            lambda parameters: jax.lax.map(lambda frames: of_parameters(exact, n_p=1)(parameters, frames), BATCH)
        )
    )(PARAMETERS)
    plainly = jax.jit(jax.jacfwd(of_parameters(plain, n_p=1)))
    for i, frames in enumerate(BATCH):
        expected = plainly(item(sets, i), frames)
        assert_close(item(together, i), expected)
        assert_close(item(mapped, i), expected)
        assert_close(item(outside, i), plainly(PARAMETERS, frames))


def test_single_precision_pixels_with_double_precision_parameters():
    frames = FRAMES.astype(jnp.float32)
    found = jax.jit(jax.jacfwd(of_parameters(exact, n_p=1)))(PARAMETERS, frames)
    assert {leaf.dtype for leaf in jax.tree.leaves(found)} == {np.dtype("float32")}
    assert_close(found, jax.jit(jax.jacfwd(of_parameters(plain, n_p=1)))(PARAMETERS, frames), 2e-5)
    assert_close(found, jax.jit(jax.jacfwd(of_parameters(exact, n_p=1)))(PARAMETERS, FRAMES), 2e-5)
    reverse = jax.jit(jax.grad(lambda parameters: of_parameters(exact)(parameters, frames)[0].sum()))(PARAMETERS)
    assert {leaf.dtype for leaf in jax.tree.leaves(reverse)} == {np.dtype("float64")}


def test_a_solver_finds_the_parameters():
    target = lgmd.LGMD2(PARAMETERS, THRESHOLDS[0])(FRAMES, 30.0).smp

    def residuals(scales, frames):
        theta2, tau1, T_s = jnp.exp(scales) * jnp.array([1.3, 30.0, 15.0])
        parameters = eqx.tree_at(lambda p: (p.theta2, p.tau1, p.T_s), PARAMETERS, (theta2, tau1, T_s))
        return lgmd.LGMD2(parameters, THRESHOLDS[0])(frames, 30.0).smp - target

    solver = optx.LevenbergMarquardt(rtol=1e-10, atol=1e-12)
    solution = optx.least_squares(residuals, solver, jnp.array([0.2, -0.2, 0.1]), FRAMES)
    np.testing.assert_allclose(solution.value, 0, atol=1e-6)


WITH_BORDER = math.prod(np.add(FRAMES[0].shape, 2))


def maps_carried(function, *arguments, size=WITH_BORDER):
    """How many arrays of a size, by default a frame's with its border, the scan that remembers most carries along."""

    def scans(jaxpr):
        for equation in jaxpr.eqns:
            if equation.primitive.name == "scan":
                outputs = zip(equation.outvars, equation.params["jaxpr"].jaxpr.outvars, strict=True)
                # What is stacked has one axis more than what a step returns.
                carried = [math.prod(last.aval.shape) for last, own in outputs if last.aval.shape == own.aval.shape]
                yield sum(each // size for each in carried)
            for inner in jax.tree.leaves(list(equation.params.values()), is_leaf=lambda it: hasattr(it, "eqns")):
                inner = getattr(inner, "jaxpr", inner)
                if hasattr(inner, "eqns"):
                    yield from scans(inner)

    return max(scans(jax.make_jaxpr(function)(*arguments).jaxpr))


# ON, OFF, D_on and D_off, the persistence, and one to lay a border onto.
@pytest.mark.parametrize(("n_p", "own"), [(0, 5), (2, 7)])
def test_only_what_is_perturbed_and_remembers_carries_maps(n_p, own):
    more = {"tau1": 2, "sigma1": 4, "u": 4 + n_p if n_p else 0}
    for name in lgmd.symbols():

        def response(value, name=name):
            return lgmd.LGMD2(with_value(name, value), THRESHOLDS[0], n_p=n_p)(FRAMES, 30.0).smp_adapted

        value = getattr(PARAMETERS, name)
        assert maps_carried(jax.jacfwd(response), value) == own + more.get(name, 0), name


def test_the_jacobian_is_computed_once_for_all_tangents():
    """Under `jacfwd` no map is batched over parameters."""
    batched_map = re.compile(rf"f64\[{len(lgmd.symbols())},(\d+,)?7,8\]")
    for potentials, batches in ((exact, False), (plain, True)):
        jaxpr = str(jax.make_jaxpr(jax.jacfwd(of_parameters(potentials)))(PARAMETERS))
        assert bool(batched_map.search(jaxpr)) == batches


@pytest.mark.parametrize(
    ("rule", "n_p"), [("exact", 0), *(pytest.param(rule, 1, marks=pytest.mark.slow) for rule in ("exact", "plain"))]
)
def test_memory_does_not_grow_with_the_frames(rule, n_p):
    """Temporary memory of the compiled gradient for one more frame, in frames."""

    def loss(parameters, frames):
        return of_parameters({"exact": exact, "plain": plain}[rule], n_p=n_p)(parameters, frames)[0].sum()

    def temporary(time):
        frames = jax.ShapeDtypeStruct((time, 40, 50), jnp.float64)
        analysis = jax.jit(jax.grad(loss)).lower(PARAMETERS, frames).compile().memory_analysis()
        assert analysis is not None
        return analysis.temp_size_in_bytes

    growth = (temporary(110) - temporary(10)) / 100 / (40 * 50 * 8)
    assert growth < 0.05 if rule == "exact" else growth > 1


@pytest.mark.parametrize("structure", STRUCTURES, ids=str)
def test_the_fast_scan_is_the_plain_one(structure):
    for thresholds in (lgmd.Hard(), *THRESHOLDS):
        model = lgmd.LGMD2(PARAMETERS, thresholds, **structure)
        assert_close(exact(model), plain(model), 1e-12)
