"""When a step is accepted, and how long the next one may be, on steps whose gain ratio is known."""

import jax
import jax.numpy as jnp
import lineax as lx
import pytest

from lgmd2jax.fitting._solver.gain_ratio import GainRatio, GainRatioState, ResidualJac

START = jnp.array([0.0])
SEARCH = GainRatio()


def at(y, bend=0.0):
    """A residual of slope 1 at 0 that is 0 at 1 without a bend, with its Jacobian."""

    def residual(y):
        return jnp.stack([y[0] - 1 + bend * y[0] ** 2])

    jacobian = jax.jacfwd(residual)(y)
    structure = jax.eval_shape(lambda: y)
    return ResidualJac(residual(y), lx.PyTreeLinearOperator(jacobian, structure))


def after(step, bend=0.0, state=None, first=False):
    """Whether a step from 0 is accepted, and the state after it; the step size before is 1."""
    state = state or GainRatioState(jnp.array(1.0), jnp.array(2.0), jnp.array(0.5))
    y = jnp.array([step])
    _, accepted, _, new = SEARCH.step(jnp.array(first), START, y, at(START, bend), at(y, bend), state)
    return bool(accepted), new


def test_a_good_step_that_the_damping_shortened_grows():
    """Half way to the minimum of a linear residual: it falls as predicted."""
    accepted, new = after(0.5)
    assert accepted
    assert new.step_size == 5


def test_a_whole_step_does_not_grow_however_good():
    """The Gauss-Newton step itself: no damping shortened it, so that less damping would change nothing."""
    accepted, new = after(1.0)
    assert accepted
    assert new.step_size == 1


@pytest.mark.parametrize(("ratio", "grows"), [(0.8, True), (0.7, False), (0.1, False)])
def test_only_a_step_that_falls_nearly_as_far_as_predicted_grows(ratio, grows):
    """The bend is such that the half sum of squares falls by this share of what is predicted, .375."""
    reached = jnp.sqrt(2 * (0.5 - 0.375 * ratio))
    accepted, new = after(0.5, bend=float((0.5 - reached) / 0.25))
    assert accepted
    assert new.step_size == (5 if grows else 1)


def test_successive_rejections_shrink_ever_faster():
    state, sizes = None, []
    for _ in range(3):
        accepted, state = after(0.5, bend=-8.0, state=state)  # the residual grows
        assert not accepted
        sizes.append(float(state.step_size))
    assert sizes == [1 / 2, 1 / 8, 1 / 64]
    assert state is not None
    accepted, new = after(0.5, state=state)
    assert accepted
    assert new.shrink == 2


def test_the_first_point_is_always_accepted_and_does_not_grow():
    for bend in (0.0, -8.0):  # a good step, were it one, and a bad one
        accepted, new = after(0.5, bend=bend, first=True)
        assert accepted
        assert new.step_size == 1
