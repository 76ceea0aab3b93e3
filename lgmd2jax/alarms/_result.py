"""What a fit of alarms found."""

import dataclasses
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax.alarms._report import Held, text
from lgmd2jax.alarms._watch import Watch
from lgmd2jax.fitting._free import Free


class Descended(NamedTuple):
    """One start: its number, the margin that the search had found and the one after the descent, and its cost."""

    start: int
    before: float
    after: float
    cost: float


@dataclasses.dataclass(frozen=True)
class AlarmFit:
    """A model that was fitted to labelled clips.

    - `model`: what is handed over, with hard thresholds.
    - `cost`: the weight of what it gets wrong; 0 where it is right on all clips.
    - `margin`: how far T_sp may move, up or down, before a verdict changes, in units of U'.
    - `watch`: what it does on the clips.
    - `screened`, `right`: how many parameter sets were tried anywhere within the bounds, and how many of them were
      right on all clips.
    - `ranges`: between which values each parameter lay in those.
    - `descended`: the best starts, and what descending brought.
    - `left_out`: for each clip what the set at least risk without it gets wrong on it; empty for many clips.
    - `stopped`: whether it was stopped by hand.
    """

    model: LGMD2
    free: Free
    z: Float[np.ndarray, " free"]
    cost: float
    margin: float
    watch: Watch
    screened: int
    right: int
    ranges: Mapping[str, tuple[float, float]]
    descended: tuple[Descended, ...]
    left_out: Mapping[str, int]
    stopped: bool

    def summary(self, held: Held | None = None) -> str:
        """The report as text. `held`: what models do on clips that the fit did not see."""
        return text(self, held)
