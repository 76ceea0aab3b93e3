"""Least squares inside a box: Levenberg-Marquardt with scaling and an active set, for `optx.least_squares`."""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import lineax as lx
import optimistix as optx
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, Float, Int, PyTree, Scalar

from lgmd2jax.fitting._solver.box_descent import DampedBoxDescent, DampedBoxState
from lgmd2jax.fitting._solver.gain_ratio import GainRatio, GainRatioState, ResidualJac


class BoundedLevenbergMarquardt(optx.AbstractLeastSquaresSolver):
    """The Levenberg-Marquardt method for nonlinear least squares with bounds on the variables.

    ```python
    solver = BoundedLevenbergMarquardt(rtol=1e-8, atol=1e-12, lower=0.0, upper=1.0)
    solution = optx.least_squares(residuals, solver, y0, throw=False)
    ```

    - The damping is scaled by the columns of the Jacobian (Marquardt; the largest norm so far, as in MINPACK), so that
      the units of the variables do not matter. A variable without influence stays where it is.
    - A variable on a bound is held while the gradient points outwards. A step that meets a bound goes on along it.
    - It has converged where the *whole* Gauss-Newton step within the box would change the residuals by no more than
      `atol + rtol * norm(residuals)`, or no variable by more than its rounding error: a short step behind rejected ones
      is no convergence. This is the relative offset of Bates and Watts (1981): with `rtol` = 1e-4 the half sum of
      squares has still 1e-8 of its value to fall. Directions that the residuals do not determine do not count.
    - A point whose residuals or Jacobian are not finite is rejected. When no step is left that lowers the sum of
      squares (it is not smooth there, or the tolerance lies below the rounding error), the result is
      `RESULTS.nonlinear_divergence`; when the start is not finite, `RESULTS.nonfinite`.

    Unlike in other Gauss-Newton solvers of optimistix the state consists of arrays alone (the Jacobian is held as a
    matrix), so that `jit` and `vmap` may return it. Each step evaluates the residuals and the Jacobian once.
    `solution.stats` holds `num_accepted_steps` and `offset`, the norm that is compared with the tolerance.
    Differentiating the solution assumes that no bound is active.

    The Jacobian is computed in forward mode.

    **Arguments:** `rtol` and `atol` as above. `lower` and `upper` are numbers, or pytrees of which the variables'
    pytree is an extension; infinite where there is no bound, equal to fix a variable. A start outside is moved onto the
    bound.

    **Raises:** `ValueError` for a lower bound above the upper one.
    """

    rtol: float
    atol: float
    norm: Callable[[PyTree], Scalar]
    descent: DampedBoxDescent
    search: GainRatio

    def __init__(self, rtol: float, atol: float, lower: PyTree = -jnp.inf, upper: PyTree = jnp.inf):
        self.rtol = rtol
        self.atol = atol
        self.norm = optx.two_norm  # optimistix asks for it
        self.descent = DampedBoxDescent(lower, upper)
        self.search = GainRatio()

    def init(self, fn, y, args, options, f_struct, aux_struct, tags) -> "_State":
        del f_struct
        f_info, _ = eqx.filter_eval_shape(_evaluate, fn, y, args, tags)
        f_info, aux = jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), (f_info, aux_struct))
        lower, upper = self.descent.box(y)
        return _State(
            first_step=jnp.array(True),
            y_eval=jax.tree.map(jnp.clip, y, lower, upper),
            search_state=self.search.init(y, f_info),
            descent_state=self.descent.init(y, f_info),
            f_info=f_info,
            aux=aux,
            offset=jnp.array(jnp.inf, ravel_pytree(y)[0].dtype),
            terminate=jnp.array(False),
            result=optx.RESULTS.successful,
            num_accepted_steps=jnp.array(0),
        )

    def step(self, fn, y, args, options, state: "_State", tags) -> tuple[PyTree, "_State", PyTree]:
        f_eval_info, aux_eval = _evaluate(fn, state.y_eval, args, tags)
        step_size, accept, _, search_state = self.search.step(
            state.first_step, y, state.y_eval, state.f_info, f_eval_info, state.search_state
        )
        new = state.y_eval, f_eval_info, aux_eval, self.descent.query(state.y_eval, f_eval_info, state.descent_state)
        old = y, state.f_info, state.aux, state.descent_state
        y, f_info, aux, descent_state = jax.tree.map(lambda a, b: jnp.where(accept, a, b), new, old)

        size = self.norm(f_info.residual)
        whole, _ = self.descent.step(jnp.array(jnp.inf), descent_state)
        offset = self.norm(f_info.jac.mv(whole))
        converged = (offset <= self.atol + self.rtol * size) | _negligible(whole, y)

        y_diff, _ = self.descent.step(step_size, descent_state)
        y_eval = jax.tree.map(_move, y, y_diff, *self.descent.box(y))
        no_change = self.norm(f_info.jac.mv(y_diff)) <= jnp.finfo(size.dtype).eps * size
        stalled = (no_change | _negligible(y_diff, y)) & ~converged
        result = optx.RESULTS.where(stalled, optx.RESULTS.nonlinear_divergence, optx.RESULTS.successful)
        result = optx.RESULTS.where(jnp.isfinite(f_info.as_min()), result, optx.RESULTS.nonfinite)
        state = _State(
            first_step=jnp.array(False),
            y_eval=y_eval,
            search_state=search_state,
            descent_state=descent_state,
            f_info=f_info,
            aux=aux,
            offset=offset.astype(state.offset.dtype),
            terminate=converged | (result != optx.RESULTS.successful),
            result=result,
            num_accepted_steps=state.num_accepted_steps + accept,
        )
        return y, state, aux

    def terminate(self, fn, y, args, options, state: "_State", tags) -> tuple[Bool[Array, ""], optx.RESULTS]:
        return state.terminate, state.result

    def loss(self, state: "_State") -> Scalar:
        """Half the sum of squares at the last accepted point."""
        return state.f_info.as_min()

    def postprocess(self, fn, y, aux, args, options, state: "_State", tags, result) -> tuple[PyTree, PyTree, dict]:
        return y, aux, {"num_accepted_steps": state.num_accepted_steps, "offset": state.offset}


class _State(eqx.Module):
    """`y_eval` is the point to be tried next; `f_info`, `aux` and `offset` belong to the last accepted one."""

    first_step: Bool[Array, ""]
    y_eval: PyTree[Array]
    search_state: GainRatioState
    descent_state: DampedBoxState
    f_info: ResidualJac
    aux: PyTree
    offset: Float[Array, ""]
    terminate: Bool[Array, ""]
    result: optx.RESULTS
    num_accepted_steps: Int[Array, ""]


def _evaluate(fn, y, args, tags) -> tuple[ResidualJac, PyTree]:
    """Residuals and Jacobian at `y`; the residuals are NaN where the Jacobian is not finite, so that it is rejected."""

    def residual_twice(y):
        residual, aux = fn(y, args)
        return residual, (residual, aux)

    jac, (residual, aux) = jax.jacfwd(residual_twice, has_aux=True)(y)
    finite = _all(jax.tree.map(jnp.isfinite, jac))
    structure = jax.eval_shape(lambda: residual)
    residual = jax.tree.map(lambda r: jnp.where(finite, r, jnp.nan), residual)
    return ResidualJac(residual, lx.PyTreeLinearOperator(jac, structure, tags)), aux


def _all(tree: PyTree[Array]) -> Bool[Array, ""]:
    return jnp.all(jnp.stack([jnp.all(leaf) for leaf in jax.tree.leaves(tree)]))


def _negligible(y_diff: PyTree[Array], y: PyTree[Array]) -> Bool[Array, ""]:
    return _all(jax.tree.map(lambda d, x: jnp.abs(d) <= jnp.finfo(x.dtype).eps * jnp.abs(x), y_diff, y))


def _move(y: Array, diff: Array, lower: Array, upper: Array) -> Array:
    """The point y + diff, exactly on a bound where it leads onto one."""
    moved = jnp.clip(y + diff, lower, upper)
    return jnp.where(diff >= upper - y, upper, jnp.where(diff <= lower - y, lower, moved))
