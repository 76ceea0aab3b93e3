"""How curves and differences change with the free parameters."""

from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax.fitting._poisson import bin_means
from lgmd2jax.fitting._problem import Curves, Problem


class Sensitivity(NamedTuple):
    """Residuals and curves at a point, with their derivatives by the point in the unit box."""

    residuals: Float[Array, " n"]
    jacobian: Float[Array, "n free"]
    curves: Curves
    slopes: list[list[Float[Array, "_ _ free"]]]


@traced_once
def sensitivity_at(problem: Problem, z: Float[Array, " free"], temperature: Float[Array, ""] | None) -> Sensitivity:
    """All derivatives in one pass."""

    def everything(z):
        evaluated = problem.evaluated(z, temperature)
        return evaluated, evaluated

    (jacobian, slopes), (residuals, curves) = jax.jacfwd(everything, has_aux=True)(z)
    return Sensitivity(residuals, jacobian, curves, slopes)


def known_rows(
    problem: Problem, slopes: Sensitivity
) -> tuple[Float[np.ndarray, "known free"], Float[np.ndarray, " known"]]:
    """The Jacobian and the residuals that count, from which errors follow: of counts those of Pearson.

    Their Jacobian J^T J is Fisher's information, and J^T r the slope of half the deviance.
    """
    jacobian, residuals, begin = np.array(slopes.jacobian), np.array(slopes.residuals), 0
    for batch, predicted, by_z in zip(problem.batches, slopes.curves, slopes.slopes, strict=True):
        for slot, curve, slope in zip(batch.slots, predicted, by_z, strict=True):
            rows = slice(begin, begin := begin + curve.size)
            if slot.is_counts:
                exposure, means = np.asarray(slot.exposure).ravel(), np.asarray(slot.means(curve)).ravel()
                counts = np.asarray(slot.low).ravel() * exposure
                residuals[rows] = np.where(exposure > 0, (means - counts) / np.sqrt(means), 0)
                by_bin = np.asarray(jax.vmap(bin_means)(slope, slot.exposure > 0)).reshape(curve.size, -1)
                jacobian[rows] = (exposure / np.sqrt(means))[:, None] * by_bin
    known = problem.known()
    return jacobian[known], residuals[known]
