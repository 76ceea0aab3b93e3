"""What became of one start of a fit to curves."""

import dataclasses
from collections.abc import Mapping
from typing import Any


@dataclasses.dataclass(frozen=True)
class Run:
    """One start from the search to the end of its descents.

    - `start`, `z`: first and best point in the unit box.
    - `start_loss`, `loss`: of the model with its own thresholds at these points.
    - `soft_loss`: at the last temperature, where the last descent ended.
    - `history`: the losses after every step, a list for each descent. There is one descent for each temperature, and
      the best run has one more at the last temperature if it had not converged there.
    - `result`: `"converged"`, or why the last descent stopped.
    """

    start: tuple[float, ...]
    z: tuple[float, ...]
    start_loss: float
    loss: float
    soft_loss: float
    history: tuple[tuple[float, ...], ...]
    result: str

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> "Run":
        """The run from plain data, as JSON gives it back."""
        history = tuple(tuple(losses) for losses in plain["history"])
        return cls(**{**plain, "start": tuple(plain["start"]), "z": tuple(plain["z"]), "history": history})

    @property
    def steps(self) -> int:
        """Steps of the solver in all descents."""
        return sum(len(losses) for losses in self.history)
