"""The bounded solver against scipy's trust region reflective method, and where a solver may lie about convergence."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
import pytest
from scipy import optimize

from lgmd2jax.fitting._solver.levenberg_marquardt import BoundedLevenbergMarquardt, _move

SCIPY: Any = optimize.least_squares
TIME = np.linspace(0, 4, 60)
NOISE = np.random.default_rng(0).normal(size=60)


def decay(y, scaling):
    """An exponential decay, a exp(-b t) + c; `scaling` multiplies the variables."""
    a, b, c = y * scaling
    return a * jnp.exp(-b * TIME) + c


def decay_residuals(y, args):
    scaling, data = args
    return decay(y, scaling) - data


def product_residuals(y, args):
    """Only the product of the first and the last variable matters."""
    return decay_residuals(jnp.array([y[0] * y[3], y[1], y[2]]), args)


def kowalik_osborne_residuals(x, args):
    u = jnp.array([4, 2, 1, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625])
    y = jnp.array([0.1957, 0.1947, 0.1735, 0.16, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246])
    return y - x[0] * (u**2 + u * x[1]) / (u**2 + u * x[2] + x[3])


def rosenbrock_residuals(y, args):
    return jnp.array([10 * (y[1] - y[0] ** 2), 1 - y[0]])


def clean(noise, scaling=(1, 1, 1)):
    return jnp.asarray(scaling, float), jnp.asarray(decay(np.array([2, 1.3, 0.5]), np.ones(3)) + noise * NOISE)


FREE, BIG = [-np.inf] * 4, [np.inf] * 4
BADLY = np.array([1e6, 1e-6, 1])
PROBLEMS = {  # residuals, args, start, lower, upper, how many bounds are active, whether the optimum is one point
    "inside": (decay_residuals, clean(0.05), [1, 3, 0.1], [0, 0, 0], [10, 10, 10], 0, True),
    "exact data": (decay_residuals, clean(0), [1, 3, 0.1], [0, 0, 0], [10, 10, 10], 0, True),
    "on one bound": (decay_residuals, clean(0.05), [1, 0.5, 0.1], [0, 0, 0], [10, 1, 10], 1, True),
    "on several bounds": (decay_residuals, clean(0.05), [1, 0.5, 0.1], [0, 0, 0.1], [1.5, 1, 0.4], 2, True),
    "noisy": (decay_residuals, clean(1), [1, 0.5, 0.1], [0, 0, 0], [10, 10, 10], 0, True),
    "scaled by 1e6": (decay_residuals, clean(0.05, BADLY), [1, 3, 0.1] / BADLY, [0, 0, 0], 10 / BADLY, 0, True),
    "scaled, bound": (
        decay_residuals,
        clean(0.05, BADLY),
        [1, 0.5, 0.1] / BADLY,
        [0, 0, 0],
        [10, 1, 10] / BADLY,
        1,
        True,
    ),
    "rank-deficient": (product_residuals, clean(0.05), [1, 3, 0.1, 1], [0] * 4, [10] * 4, 0, False),
    "rank-deficient, bounds": (product_residuals, clean(0.05), [1, 0.5, 0.1, 1], [0] * 4, [1.1, 1, 10, 1.2], 3, True),
    "Rosenbrock, bound": (rosenbrock_residuals, None, [-1.2, 1], [-2, -2], [0.5, 2], 1, True),
    "Kowalik-Osborne": (kowalik_osborne_residuals, None, [0.25, 0.39, 0.415, 0.39], FREE, BIG, 0, True),
    "Kowalik-Osborne, bounds": (
        kowalik_osborne_residuals,
        None,
        [0.25, 0.39, 0.415, 0.39],
        [0, -1, 0.13, 0.12],
        [10, 12, 13, 12],
        1,
        True,
    ),
}


def solver(lower: Any = -np.inf, upper: Any = np.inf):
    return BoundedLevenbergMarquardt(1e-8, 1e-10, jnp.asarray(lower, float), jnp.asarray(upper, float))


def solve(residuals, y0, args=None, lower: Any = -np.inf, upper: Any = np.inf, max_steps=256):
    given = solver(lower, upper)
    return optx.least_squares(residuals, given, jnp.asarray(y0, float), args, throw=False, max_steps=max_steps)


@pytest.fixture(scope="module")
def solved():
    """Our solution and that of scipy for each problem."""
    jitted = {fn: (jax.jit(fn), jax.jit(jax.jacfwd(fn))) for fn in {problem[0] for problem in PROBLEMS.values()}}
    solutions = {}
    for name, (residuals, args, start, lower, upper, _, _) in PROBLEMS.items():
        value, slope = jitted[residuals]
        box = np.asarray(lower, float)[: len(start)], np.asarray(upper, float)[: len(start)]
        theirs = SCIPY(
            lambda y, args, value=value: np.asarray(value(y, args)),
            np.asarray(start, float),
            jac=lambda y, args, slope=slope: np.asarray(slope(y, args)),
            args=(args,),
            bounds=box,
            method="trf",
            x_scale="jac",
            **dict.fromkeys(("xtol", "ftol", "gtol"), 1e-14),
        )
        solutions[name] = solve(residuals, start, args, *box), theirs
    return solutions


@pytest.mark.parametrize("name", PROBLEMS)
def test_finds_the_optimum_of_scipy(solved, name):
    ours, theirs = solved[name]
    residuals, args, _, lower, upper, active, unique = PROBLEMS[name]
    assert ours.result == optx.RESULTS.successful
    y = np.asarray(ours.value)
    cost = 0.5 * float(jnp.sum(residuals(ours.value, args) ** 2))
    assert cost <= theirs.cost * (1 + 1e-8) + 1e-20
    assert theirs.cost <= cost * (1 + 1e-8) + 1e-20
    if unique:
        np.testing.assert_allclose(y, theirs.x, rtol=1e-6)
    on_bound = (y == np.asarray(lower, float)[: len(y)]) | (y == np.asarray(upper, float)[: len(y)])
    assert on_bound.sum() == active, "a variable on a bound is on it exactly"


def test_needs_about_as_many_evaluations_as_scipy(solved, record_property):
    rows = [(name, int(ours.stats["num_steps"]), theirs.nfev) for name, (ours, theirs) in solved.items()]
    lines = [f"{name:24} {ours:5d} {theirs:5d}" for name, ours, theirs in rows]
    record_property("table", "\n".join([f"{'evaluations':24} {'ours':>5} {'trf':>5}", *lines]))
    assert sum(ours for _, ours, _ in rows) <= sum(theirs for _, _, theirs in rows)
    assert all(ours <= 2 * theirs + 5 for _, ours, theirs in rows)


def test_all_of_64_noisy_starts_converge_under_vmap(solved):
    box = jnp.array([0.2, 0.05, -2]), jnp.array([10.0, 10, 2])
    starts = jax.random.uniform(jax.random.key(0), (64, 3), minval=box[0], maxval=box[1])

    @jax.jit
    def many(starts, args):
        def one(y0):
            solution = optx.least_squares(decay_residuals, solver(*box), y0, args, throw=False)
            return solution.value, solution.result == optx.RESULTS.successful, solution.stats["num_steps"]

        return jax.vmap(one)(starts)

    args = clean(0.3)
    values, successful, steps = many(starts, args)
    assert successful.all()
    assert np.median(steps) < 20
    best = SCIPY(lambda y: np.asarray(decay_residuals(y, args)), [1, 1, 0.5], xtol=1e-14, ftol=1e-14, gtol=1e-14)
    np.testing.assert_allclose(values, np.broadcast_to(best.x, (64, 3)), rtol=1e-6)


def test_many_active_bounds_end_where_no_feasible_step_leads_down():
    """Random saturating problems in eight variables, half of which end on a bound, some having left another one."""
    rng = np.random.default_rng(0)
    slopes, data, starts = rng.normal(size=(100, 20, 8)), rng.normal(size=(100, 20)), rng.uniform(size=(100, 8))
    starts = np.where(starts < 0.3, 0, starts)

    def residuals(y, args):
        slopes, data = args
        return jnp.tanh(slopes @ y) + 0.3 * (slopes @ y) - data

    @jax.jit
    @jax.vmap
    def ended(y0, args):
        solution = optx.least_squares(residuals, solver(0, 1), y0, args, throw=False)
        y = solution.value
        gradient = jax.grad(lambda y: 0.5 * jnp.sum(residuals(y, args) ** 2))(y)
        return y, solution.result == optx.RESULTS.successful, jnp.clip(y - gradient, 0, 1) - y

    values, successful, downhill = ended(starts, (slopes, data))
    assert successful.all()
    np.testing.assert_allclose(downhill, 0, atol=1e-6)
    assert 0.4 < np.mean((values == 0) | (values == 1)) < 0.6


def test_driven_by_hand_as_by_optimistix():
    residuals, args, start, lower, upper, _, _ = PROBLEMS["on one bound"]
    given, y = solver(lower, upper), jnp.asarray(start, float)

    def fn(y, args):
        return residuals(y, args), None

    struct = jax.eval_shape(fn, y, args)
    state = given.init(fn, y, args, {}, struct[0], struct[1], frozenset())
    assert all(eqx.is_array(leaf) for leaf in jax.tree.leaves(state))
    step = eqx.filter_jit(lambda y, state: given.step(fn, y, args, {}, state, frozenset()))
    steps = 0
    while not given.terminate(fn, y, args, {}, state, frozenset())[0]:
        y, state, _ = step(y, state)
        steps += 1
    solution = solve(residuals, start, args, lower, upper)
    np.testing.assert_array_equal(y, solution.value)
    assert steps == solution.stats["num_steps"]


def test_the_first_step_is_compiled_for_all():
    """What a step returns has the types of what init gave, so that no second program is compiled."""
    y, compiled = jnp.array([1.0, 3, 0.1]), 0

    def fn(y, args):
        nonlocal compiled
        compiled += 1
        return decay_residuals(y, args), None

    given, args = solver(0.0, jnp.array([1.5, 10, 10])), clean(0.05)
    struct = jax.eval_shape(fn, y, args)
    state = eqx.filter_jit(lambda y: given.init(fn, y, args, {}, struct[0], struct[1], frozenset()))(y)
    step = eqx.filter_jit(lambda y, state: given.step(fn, y, args, {}, state, frozenset()))
    y, state, _ = step(y, state)
    after_one = compiled
    for _ in range(3):
        y, state, _ = step(y, state)
    assert compiled == after_one


def test_pytrees_of_variables_residuals_and_bounds():
    def residuals(y, args):
        tail = y["tail"]
        return {
            "sum": y["gain"] * jnp.array([1.0, 2]) - 3,
            "tail": tail - jnp.array([5.0, -1]),
            "mixed": tail[0] - y["gain"],
        }

    y0 = {"gain": jnp.array(0.0), "tail": jnp.zeros(2)}
    lower, upper = {"gain": jnp.array(0.0), "tail": jnp.array(-0.5)}, {"gain": 9.0, "tail": jnp.array([2.0, 4])}
    given = BoundedLevenbergMarquardt(1e-10, 1e-10, lower, upper)
    solution = optx.least_squares(residuals, given, y0)
    np.testing.assert_array_equal(solution.value["tail"], [2, -0.5])
    np.testing.assert_allclose(solution.value["gain"], 11 / 6)  # the mean of (3, 3/2, 2) by squared slopes


def test_float32_stays_float32():
    args = jax.tree.map(lambda x: x.astype(jnp.float32), clean(0.05))
    y0 = jnp.array([1, 3, 0.1], jnp.float32)
    given = BoundedLevenbergMarquardt(1e-4, 1e-6, 0.0, jnp.array([1.5, 10, 10]))
    solution = optx.least_squares(lambda y, a: decay_residuals(y, a).astype(jnp.float32), given, y0, args, throw=False)
    assert solution.value.dtype == jnp.float32
    assert solution.result == optx.RESULTS.successful
    exact = solve(decay_residuals, y0, clean(0.05), 0, [1.5, 10, 10])
    np.testing.assert_allclose(solution.value, exact.value, rtol=1e-4)


def test_crossed_bounds_are_refused():
    with pytest.raises(ValueError, match=r"lower bound 2.0 lies above the upper bound 1.0"):
        BoundedLevenbergMarquardt(1e-8, 1e-8, 2.0, 1.0)


def test_equal_bounds_hold_a_variable():
    solution = solve(decay_residuals, [1, 3, 0.1], clean(0.0), [0, 1.3, 0], [10, 1.3, 10])
    np.testing.assert_allclose(solution.value, [2, 1.3, 0.5], rtol=1e-8)
    assert solution.value[1] == 1.3


def test_a_step_onto_a_bound_ends_on_it_exactly():
    """Y + (bound - y) is not the bound where the subtraction rounds."""
    chance = np.random.default_rng(0)
    y, upper, lower = chance.uniform(0.1, 1, 1000), chance.uniform(1, 3, 1000), -chance.uniform(0.01, 0.1, 1000)
    assert (np.minimum(y + (upper - y), upper) != upper).any()
    assert (np.maximum(y + (lower - y), lower) != lower).any()
    y, lower, upper = map(jnp.asarray, (y, lower, upper))
    np.testing.assert_array_equal(_move(y, upper - y, lower, upper), upper)
    np.testing.assert_array_equal(_move(y, lower - y, lower, upper), lower)
    np.testing.assert_array_equal(_move(y, 2 * (upper - y), lower, upper), upper)
    np.testing.assert_array_equal(_move(y, jnp.zeros_like(y), lower, upper), y)


@pytest.mark.parametrize("start", [[0, 0, 0], [10, 10, 10], [-5, 50, 0.1]])
def test_starts_on_and_beyond_the_bounds(start):
    solution = solve(decay_residuals, start, clean(0.0), 0, 10)
    assert solution.result == optx.RESULTS.successful
    y = np.asarray(solution.value)
    residual, slope = decay_residuals(y, clean(0.0)), jax.jacfwd(decay_residuals)(y, clean(0.0))
    gradient = np.asarray(residual @ slope)
    downhill = np.clip(y - gradient, 0, 10) - y  # zero where no feasible step lowers the cost
    np.testing.assert_allclose(downhill, 0, atol=1e-8)


def test_a_variable_without_influence_stays_and_hinders_nothing():
    def residuals(y, args):
        return decay_residuals(y[:3], args)

    solution = solve(residuals, [1, 3, 0.1, 0.37], clean(0.0), 0, 10)
    assert solution.result == optx.RESULTS.successful
    np.testing.assert_allclose(solution.value, [2, 1.3, 0.5, 0.37], rtol=1e-8)


def test_at_a_point_where_a_variable_has_no_influence_yet():
    # With a = 0 the rate b does nothing; a then wakes it.
    solution = solve(decay_residuals, [0, 3, 0], clean(0.0), 0, 10)
    np.testing.assert_allclose(solution.value, [2, 1.3, 0.5], rtol=1e-8)


def test_a_point_that_is_not_finite_is_rejected():
    def residuals(y, args):  # the first full step leads to y < 0
        return jnp.array([jnp.log(y[0]) + 2.0, 0.0])

    solution = solve(residuals, [5.0])
    assert solution.result == optx.RESULTS.successful
    assert solution.stats["num_accepted_steps"] < solution.stats["num_steps"]
    np.testing.assert_allclose(solution.value, np.exp(-2.0))


def test_a_jacobian_that_is_not_finite_is_rejected():
    def residuals(y, args):  # the first full step leads to y = 0, where the slope is infinite
        return jnp.sqrt(jnp.maximum(y, 0)) + y - 0.5

    solution = solve(residuals, [4.0])
    assert solution.result == optx.RESULTS.successful
    np.testing.assert_allclose(residuals(solution.value, None), 0, atol=1e-9)


def test_a_start_that_is_not_finite_is_reported():
    assert solve(lambda y, args: jnp.log(y), [-1.0]).result == optx.RESULTS.nonfinite


@pytest.mark.parametrize("residuals", [lambda y, args: 1 + jnp.abs(y - 0.3), lambda y, args: 1 + jnp.sign(y) * y / 3])
def test_a_kink_is_not_called_convergence(residuals):
    """Steps shrink to nothing at a kink: the difference between iterates is small, but the slope is not."""
    solution = solve(residuals, [1.0])
    assert solution.result == optx.RESULTS.nonlinear_divergence
    assert solution.stats["offset"] > 0.1


def test_a_wrong_derivative_is_not_called_convergence():
    def residuals(y, args):
        return decay_residuals(2 * jax.lax.stop_gradient(y) - y, args)

    assert solve(residuals, [1, 3, 0.1], clean(0.05), 0, 10).result == optx.RESULTS.nonlinear_divergence


def test_too_few_steps_are_no_convergence():
    assert (
        solve(decay_residuals, [1, 3, 0.1], clean(0.0), max_steps=4).result == optx.RESULTS.nonlinear_max_steps_reached
    )


def test_rounding_error_of_the_residuals_does_not_stop_it():
    """Noise of 1e-11 in the residuals hides the last gains in the sum of squares, but not in the gradients."""

    def residuals(y, args):
        noise = args[2] * jnp.sin(1e12 * jax.lax.stop_gradient(jnp.sum(y)) + jnp.arange(60.0))
        return decay_residuals(y, args[:2]) + noise

    for y0 in jax.random.uniform(jax.random.key(0), (8, 3), minval=0.5, maxval=3):
        exact, noisy = (solve(residuals, y0, (*clean(0.3), jnp.array(size)), 0, 10) for size in (0, 1e-11))
        assert noisy.result == optx.RESULTS.successful
        assert noisy.stats["num_steps"] <= exact.stats["num_steps"] + 5
