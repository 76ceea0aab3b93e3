"""How curves and differences change with the free parameters."""

from typing import NamedTuple

import equinox as eqx
import jax
from jaxtyping import Array, Float

from lgmd2jax.fitting._problem import Curves, Problem


class Sensitivity(NamedTuple):
    """Residuals and curves at a point, with their derivatives by the point in the unit box."""

    residuals: Float[Array, " n"]
    jacobian: Float[Array, "n free"]
    curves: Curves
    slopes: list[list[Float[Array, "_ _ free"]]]


@eqx.filter_jit
def sensitivity_at(problem: Problem, z: Float[Array, " free"], temperature: Float[Array, ""] | None) -> Sensitivity:
    """All derivatives in one pass."""

    def everything(z):
        evaluated = problem.evaluated(z, temperature)
        return evaluated, evaluated

    (jacobian, slopes), (residuals, curves) = jax.jacfwd(everything, has_aux=True)(z)
    return Sensitivity(residuals, jacobian, curves, slopes)
