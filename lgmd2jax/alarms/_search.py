"""The search on two levels: for a point of the pixels' parameters all clips once, then thousands of cells on that."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax.alarms._problem import AlarmProblem

_LANES = 512  # cells and clips side by side: wide enough for vectors, small enough for the cache


@eqx.filter_jit
def look(
    problem: AlarmProblem, z: Float[Array | np.ndarray, " free"], cells: Float[Array | np.ndarray, "cell searched"]
) -> Float[Array, "cell event"]:
    """The largest evidence in each event, for the pixels of `z` with each of the cells, in the unit box."""
    z = jnp.asarray(z)
    place = jnp.asarray(problem.searched, dtype=int)
    model, _ = problem.at(z)
    sums = problem.sums(model)
    clips = sum(len(reel.frames) for reel in problem.reels)

    def one(cell):
        return problem.peaks(problem.at(z.at[place].set(cell))[0], sums)

    cells = jnp.asarray(cells, dtype=z.dtype)
    return jax.lax.map(one, cells, batch_size=max(1, min(_LANES // clips, len(cells))))
