"""How much RAM the C of a model needs."""

from typing import NamedTuple

from lgmd2jax._c.source import frames_of_lag, mechanisms_of
from lgmd2jax._network.lgmd2 import LGMD2


class Memory(NamedTuple):
    """Bytes of RAM: of `lgmd2_state`, and of the frame that the camera fills."""

    state: int
    frame: int


def memory(model: LGMD2, rows: int, cols: int, urgency: bool = False) -> Memory:
    """What the C of a model needs for frames of this size. The stack takes a few hundred bytes and 12 a column more.

    **Arguments:** `urgency`: whether it tells the probability of contact.
    """
    mechanisms, pixels = mechanisms_of(model), rows * cols
    maps = 2 + sum(name in mechanisms for name in ("size", "lamina", "habituation")) + model.n_p
    delays = 2 * rows * (cols + 2)
    cell = 3 + urgency + ("membrane" in mechanisms) + 3 * frames_of_lag(model) * ("lag" in mechanisms) + (model.n_p > 0)
    bytes_alone = pixels + model.N_ts + 2
    return Memory(4 * (maps * pixels + delays + cell + -(-bytes_alone // 4)), pixels)
