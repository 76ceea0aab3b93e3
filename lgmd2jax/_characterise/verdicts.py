"""Which properties a model has: a pure function of what its pixels summed."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lgmd2jax._characterise.curves import Curves, curves_of
from lgmd2jax._characterise.exam import Exam, ExamSums
from lgmd2jax._characterise.properties import ROWS
from lgmd2jax._network.abstract import AbstractNetwork

Values = tuple[Float[Array, " _line"], ...]


def verdicts(exam: Exam, sums: ExamSums, model: AbstractNetwork) -> tuple[Values, Bool[Array, " row"]]:
    """The values of each row's lines, and which rows hold, whatever the eye undersamples.

    It maps over models: `jax.vmap(lambda model: verdicts(exam, sums, model), in_axes=...)` over cell parameters costs
    no pixels. `sums` follow from the pixels' parameters and from thresholds, not from the cell's.
    """
    return judge(curves_of(exam, sums, model))


def judge(curves: Curves) -> tuple[Values, Bool[Array, " row"]]:
    """The same of curves."""
    values = tuple(jnp.stack([jnp.asarray(value) for value in row.measure(curves)]) for row in ROWS)
    return values, jnp.stack([row.holds(lines) for row, lines in zip(ROWS, values, strict=True)])
