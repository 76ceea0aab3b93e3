"""Steps of the Levenberg-Marquardt method inside a box."""

import equinox as eqx
import jax
import jax.numpy as jnp
import jax.scipy.linalg as jsl
import numpy as np
import optimistix as optx
from jax.core import Tracer
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float, PyTree, Scalar

from lgmd2jax.fitting._solver.gain_ratio import ResidualJac


class DampedBoxState(eqx.Module):
    """At the last accepted point: gradient J^T r / D and normal matrix J^T J / (D D^T), scaled with D = `scale`."""

    y: PyTree[Array]
    scale: Float[Array, " p"]
    gradient: Float[Array, " p"]
    normal: Float[Array, "p p"]


class DampedBoxDescent(optx.AbstractDescent):
    """Steps of the Levenberg-Marquardt method that stay between `lower` and `upper`; the damping is 1/step_size.

    Minimises g^T d + d^T (J^T J + D^2/step_size) d / 2 in stages: towards the minimum over the variables that are
    free, up to the first bound, which is held in the next stage. Each stage lowers the quadratic. An infinite step
    size is the Gauss-Newton step.
    """

    lower: PyTree[Array]
    upper: PyTree[Array]

    def __init__(self, lower: PyTree, upper: PyTree):
        self.lower = jax.tree.map(jnp.asarray, lower)
        self.upper = jax.tree.map(jnp.asarray, upper)
        if jax.tree.structure(lower) == jax.tree.structure(upper):
            jax.tree.map(_check_order, self.lower, self.upper)

    def box(self, y: PyTree[Array]) -> tuple[PyTree[Array], PyTree[Array]]:
        """The bounds, one for each variable."""

        def like(bound, variables):
            return jax.tree.map(lambda x: jnp.broadcast_to(bound.astype(x.dtype), x.shape), variables)

        return jax.tree.map(like, self.lower, y), jax.tree.map(like, self.upper, y)

    def init(self, y: PyTree[Array], f_info_struct: ResidualJac) -> DampedBoxState:
        zeros = jnp.zeros_like(ravel_pytree(y)[0])
        return DampedBoxState(y, zeros, zeros, jnp.outer(zeros, zeros))

    def query(self, y: PyTree[Array], f_info: ResidualJac, state: DampedBoxState) -> DampedBoxState:
        jac = f_info.jac.as_matrix()
        scale = jnp.maximum(state.scale, jnp.linalg.norm(jac, axis=0))
        scaled = jac / jnp.where(scale > 0, scale, 1)[None, :]
        return DampedBoxState(y, scale, scaled.T @ ravel_pytree(f_info.residual)[0], scaled.T @ scaled)

    def step(self, step_size: Scalar, state: DampedBoxState) -> tuple[PyTree[Array], optx.RESULTS]:
        y, unravel = ravel_pytree(state.y)
        low, high = (ravel_pytree(bound)[0] - y for bound in self.box(state.y))
        # A relative floor keeps the Cholesky factor finite where J has not full rank.
        diagonal = jnp.diag(state.normal)
        floor = 100 * jnp.finfo(y.dtype).eps * jnp.where(diagonal > 0, diagonal, 1)
        damped = state.normal + jnp.diag(1 / step_size.astype(y.dtype) + floor)
        return unravel(_box_minimum(damped, state.gradient, state.scale, low, high)), optx.RESULTS.successful


def _check_order(low: Array, high: Array) -> None:
    known = not isinstance(low, Tracer) and not isinstance(high, Tracer)
    if known and np.any(np.asarray(low) > np.asarray(high)):
        raise ValueError(f"the lower bound {low} lies above the upper bound {high}; swap them")


def _box_minimum(
    matrix: Float[Array, "p p"],
    gradient: Float[Array, " p"],
    scale: Float[Array, " p"],
    low: Float[Array, " p"],
    high: Float[Array, " p"],
) -> Float[Array, " p"]:
    """A low point d of x^T gradient + x^T matrix x / 2, x = scale d, between `low` <= 0 and `high` >= 0."""
    scale = jnp.where(scale > 0, scale, 1)

    def stage(carry):
        d, free, _ = carry
        slope = jnp.where(free, gradient + matrix @ (scale * d), 0)
        reduced = jnp.where(free[:, None] & free[None, :], matrix, jnp.eye(len(d), dtype=d.dtype))
        move = -jsl.cho_solve(jsl.cho_factor(reduced), slope) / scale
        bound = jnp.where(move < 0, low, high)
        fraction = jnp.where(move == 0, jnp.inf, (bound - d) / jnp.where(move == 0, 1, move))
        reach = jnp.clip(jnp.min(fraction), 0, 1)
        hit = free & (fraction <= reach)
        return jnp.where(hit, bound, jnp.clip(d + reach * move, low, high)), free & ~hit, jnp.any(hit)

    # Left free, those that push outwards would take others to the bound with them that could leave it.
    held = (low == high) | ((low == 0) & (gradient > 0)) | ((high == 0) & (gradient < 0))
    start = jnp.zeros_like(gradient), ~held, jnp.array(True)
    d, _, _ = jax.lax.while_loop(lambda carry: carry[2] & jnp.any(carry[1]), stage, start)
    return d
