"""How a batch of stimuli is worked through: the one place that knows what is fast where."""

from collections.abc import Callable
from typing import Any

import jax

_ABREAST = 64  # stimuli side by side on an accelerator; bounds the memory


def each(function: Callable[[Any], Any], inputs: Any) -> Any:
    """The function of each element along the first axis of all leaves of `inputs`.

    On a CPU one after the other: at 48 x 64 that takes four fifths of the time of side by side, since the state of one
    network stays in the cache and that of 64 does not. On an accelerator side by side in groups, which fill it.
    """
    count = len(jax.tree.leaves(inputs)[0])
    abreast = None if jax.default_backend() == "cpu" else min(_ABREAST, count)
    return jax.lax.map(function, inputs, batch_size=abreast)
