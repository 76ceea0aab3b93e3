"""Where in the field the evidence lies: MP and F of its left, centre and right third."""

from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._network.maps import pool
from lgmd2jax._types import Map


class Sides(NamedTuple):
    """The shares of the left, centre and right third of the columns in MP and F: they add up to these.

    Of a frame as the pixels see it, before a lag. As what `record` returns they have time as the first axis.
    """

    mp: Float[Array, "*time 3"]
    f: Float[Array, "*time 3"]


def sides(layers: Any) -> Sides:
    """MP and F by thirds of the field, to be recorded: both networks of the library have them.

    ```python
    state, now = model.step(state, frame, fps, record=lgmd.sides)
    left, centre, right = now.recorded.mp
    ```

    The outer thirds have as many columns each as are nearest to a third, so that a mirror image swaps them.

    **Arguments:** `layers`: of a frame. Those of a network of your own need two maps: `mp`, whose sum is its MP, and
    `f`, whose mean is its F.

    **Raises:** `ValueError` for layers without them.
    """
    if not (hasattr(layers, "mp") and hasattr(layers, "f")):
        raise ValueError(f"{type(layers).__name__} has no maps mp and f; give them to the layers of your network")
    return Sides(_thirds(layers.mp, 1.0), _thirds(layers.f, 1 / layers.f.size))


def _thirds(x: Map, weight: float) -> Float[Array, "3"]:
    outer = (x.shape[1] + 1) // 3
    return jnp.stack([pool(part, weight) for part in (x[:, :outer], x[:, outer:-outer], x[:, -outer:])])
