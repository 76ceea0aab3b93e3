"""The search on two levels: for a point of the pixels' parameters all clips once, then thousands of cells on that."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax.alarms._clip_batch import Sums
from lgmd2jax.alarms._problem import AlarmProblem

_LANES = 512  # cells and clips side by side: wide enough for vectors, small enough for the cache


@traced_once
def sums_at(problem: AlarmProblem, z: Float[Array | np.ndarray, " free"]) -> tuple[Sums, ...]:
    """MP and F of every clip with the pixels of `z`: all that the cell needs."""
    return problem.sums(problem.at(jnp.asarray(z))[0])


@traced_once
def peaks_of(
    problem: AlarmProblem,
    z: Float[Array | np.ndarray, " free"],
    sums: tuple[Sums, ...],
    cells: Float[Array | np.ndarray, "cell entry"],
) -> Float[Array, "cell event"]:
    """The largest evidence in each event, for each of the cells on the sums at `z`.

    **Arguments:** `z`, `cells`: in the unit box.
    """
    z = jnp.asarray(z)
    place = jnp.asarray(problem.cell_entries, dtype=int)
    clips = sum(len(batch.frames) for batch in problem.batches)

    def one(cell):
        return problem.peaks(problem.at(z.at[place].set(cell))[0], sums)

    cells = jnp.asarray(cells, dtype=z.dtype)
    return jax.lax.map(one, cells, batch_size=max(1, min(_LANES // clips, len(cells))))
