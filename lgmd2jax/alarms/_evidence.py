"""The evidence for an alarm: the highest T_sp at which it would be raised.

Spikes and alarm (eqs 16, 17) only read the adapted potential U', so a clip's alarms at *all* thresholds follow from one
curve: the alarm is on in a frame exactly where the evidence is at least T_sp.
"""

import functools
import math

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._types import Number

NEVER = 0.0  # below every potential: no T_sp raises the alarm


def spikes_for_alarm(model: LGMD2) -> int:
    """How many spikes raise the alarm. Spikes are whole, so that an N_sp of 4.3 asks for five, as eq. 17 does."""
    return math.ceil(float(model.parameters.N_sp))


@checked
@functools.partial(jax.jit, static_argnames=("N_sp", "N_ts"))
def evidence(u: Float[Array, "*batch time"], sigma_sp: Number, N_sp: int, N_ts: int) -> Float[Array, "*batch time"]:
    """The largest T_sp at which the last N_ts + 1 frames hold N_sp spikes.

    A frame gives one spike for U' >= T_sp and another for U' > T_sp + sigma_sp. So N_sp spikes need the N_sp-th largest
    of all U' and U' - sigma_sp in the window to reach T_sp: with a frames of one spike and b of two, a + b = N_sp, the
    smaller of the a-th largest U' and the b-th largest U' - sigma_sp.

    **Arguments:** `u`: U' (eq. 15). `N_sp`, `N_ts`: whole numbers of eq. 17.
    """
    frames = N_ts + 1
    if N_sp > 2 * frames:
        return jnp.full_like(u, NEVER)
    before = jnp.full_like(u[..., :N_ts], NEVER)
    padded = jnp.concatenate([before, u], axis=-1)
    largest = _falling([padded[..., i : i + u.shape[-1]] for i in range(frames)])
    highest = []
    for b in range(max(0, N_sp - frames), min(N_sp, frames) + 1):
        a = N_sp - b
        terms = ([largest[a - 1]] if a else []) + ([largest[b - 1] - sigma_sp] if b else [])
        highest.append(functools.reduce(jnp.minimum, terms))
    return functools.reduce(jnp.maximum, highest)


def _falling(rows: list[Array]) -> list[Array]:
    """The rows sorted entry by entry: a handful of them, so that comparing neighbours beats a sort."""
    rows = list(rows)
    for end in range(len(rows) - 1, 0, -1):
        for i in range(end):
            rows[i], rows[i + 1] = jnp.maximum(rows[i], rows[i + 1]), jnp.minimum(rows[i], rows[i + 1])
    return rows
