"""When to accept a step of a least-squares solver, and how long the next one may be."""

import equinox as eqx
import jax
import jax.numpy as jnp
import optimistix as optx
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, PyTree, Scalar

# The residuals at a point, and their Jacobian as a linear operator.
ResidualJac = optx.FunctionInfo.ResidualJac

_FIRST_STEP_SIZE = 100.0
_ACCEPTED, _GOOD = 1e-3, 0.75  # ratios of actual to predicted reduction from which a step is accepted, and good
_GROWTH = 5.0  # of the step size after a good step
_DAMPED = 1e-3  # share of the curvature above which the damping counts as what shortened a step


class GainRatioState(eqx.Module):
    """`shrink` divides the step size at the next rejection; `lowest` is the lowest half sum of squares so far."""

    step_size: Scalar
    shrink: Scalar
    lowest: Scalar


class GainRatio(optx.AbstractSearch):
    """Grows or shrinks the step size by the ratio of actual to predicted reduction of the half sum of squares.

    As `optx.ClassicalTrustRegion`, but for noise and speed:
    - Where the sum of squares hardly changes, its difference is rounding error; the actual reduction is then taken from
      the gradients at both ends (the approximate Wolfe condition of Hager and Zhang, 2005), as long as the sum stays
      that close to the lowest one.
    - A step that the damping hardly shortens does not grow it further, and successive rejections shrink it ever faster
      (Nielsen, 1999), so that the way back is short.
    """

    def init(self, y: PyTree[Array], f_info_struct: ResidualJac) -> GainRatioState:
        dtype = ravel_pytree(y)[0].dtype  # that of the later states, for which a step would be compiled once more
        return GainRatioState(*(jnp.array(value, dtype) for value in (_FIRST_STEP_SIZE, 2.0, jnp.inf)))

    def step(
        self,
        first_step: Bool[Array, ""],
        y: PyTree[Array],
        y_eval: PyTree[Array],
        f_info: ResidualJac,
        f_eval_info: ResidualJac,
        state: GainRatioState,
    ) -> tuple[Scalar, Bool[Array, ""], optx.RESULTS, GainRatioState]:
        y_diff = jax.tree.map(jnp.subtract, y_eval, y)
        change = ravel_pytree(f_info.jac.mv(y_diff))[0]
        slope = ravel_pytree(f_info.residual)[0] @ change
        curvature = change @ change
        predicted = slope + curvature / 2

        now, then = f_eval_info.as_min(), f_info.as_min()
        noise = jnp.sqrt(jnp.finfo(now.dtype).eps) / 100 * then
        by_gradients = (slope + f_eval_info.compute_grad_dot(y_diff)) / 2
        actual = jnp.where(jnp.abs(now - then) < noise, by_gradients, now - then)

        low_enough = now <= state.lowest + noise
        accept = first_step | ((predicted < 0) & (actual <= _ACCEPTED * predicted) & low_enough)
        damping = -slope - curvature
        grow = ~first_step & (actual <= _GOOD * predicted) & (damping > _DAMPED * curvature)
        new = GainRatioState(
            step_size=state.step_size * jnp.where(accept, jnp.where(grow, _GROWTH, 1), 1 / state.shrink),
            shrink=jnp.where(accept, 2, 2 * state.shrink),
            lowest=jnp.where(accept, jnp.minimum(now, state.lowest), state.lowest),
        )
        new = jax.tree.map(lambda after, before: after.astype(before.dtype), new, state)
        return new.step_size, accept, optx.RESULTS.successful, new
