"""The rows of the exam, and their verdicts on one model: a pure function of what its pixels summed."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lgmd2jax._characterise import (
    rows_field as _rows_field,
    rows_looming as _rows_looming,
    rows_selectivity as _rows_selectivity,
)
from lgmd2jax._characterise.curves import Curves, curves_of
from lgmd2jax._characterise.exam import Exam, Sums
from lgmd2jax._characterise.row import Row
from lgmd2jax._network.abstract import Network

_MODULES = (_rows_looming, _rows_selectivity, _rows_field)
ROWS: tuple[Row, ...] = tuple(
    sorted((it for module in _MODULES for it in vars(module).values() if isinstance(it, Row)), key=lambda it: it.number)
)

Values = tuple[Float[Array, " _line"], ...]


def verdicts(exam: Exam, sums: Sums, model: Network) -> tuple[Values, Bool[Array, " row"]]:
    """The values of each row's lines, and which rows hold, whatever the eye undersamples.

    It maps over models: `jax.vmap(lambda model: verdicts(exam, sums, model), in_axes=...)` over cell parameters costs
    no pixels. `sums` hang on the pixels' parameters and on thresholds, not on the cell's.
    """
    return judged(curves_of(exam, sums, model))


def judged(curves: Curves) -> tuple[Values, Bool[Array, " row"]]:
    """The same of curves."""
    values = tuple(jnp.stack([jnp.asarray(value) for value in row.measure(curves)]) for row in ROWS)
    return values, jnp.stack([row.passed(lines) for row, lines in zip(ROWS, values, strict=True)])
