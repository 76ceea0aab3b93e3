"""A trial: spike times with their animal, their condition and the span of time that was recorded."""

import dataclasses
import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float

from lgmd2jax._arguments.checked import checked

Condition = Mapping[str, float | str]

_NANOSECOND = 6  # decimals of a ms: clocks of sessions and their units leave rounding below that


@checked
@dataclasses.dataclass(frozen=True, eq=False)
class Trial:
    """One presentation of a stimulus to one animal.

    **Arguments:**

    - `animal`, `session`, `name`: whose trial of which recording this is; `name` is unique in them and the condition.
    - `condition`: what was shown, by name: `l_over_v` in ms, all else as in the file.
    - `spikes_ms`: times of the spikes from the event (collision), in ms; they are sorted, and rounded to 1 ns.
    - `start_ms`, `end_ms`: what of that clock was recorded. A trial without spikes counts as any other.

    **Raises:** `ValueError` for times that are not finite, and for a spike outside of the recorded span.
    """

    animal: str
    name: str
    condition: Condition
    spikes_ms: Float[np.ndarray, " spike"]
    start_ms: float | int
    end_ms: float | int
    session: str = ""

    def __post_init__(self):
        spikes = np.round(np.sort(np.asarray(self.spikes_ms, dtype=float)), _NANOSECOND)
        for name in ("start_ms", "end_ms"):
            object.__setattr__(self, name, round(float(getattr(self, name)), _NANOSECOND))
        object.__setattr__(self, "spikes_ms", spikes)
        object.__setattr__(self, "condition", dict(self.condition))
        if not (np.all(np.isfinite(spikes)) and math.isfinite(self.end_ms - self.start_ms)):
            raise ValueError(f"{self} holds times that are no finite numbers; leave them out")
        if not self.start_ms < self.end_ms:
            raise ValueError(f"{self} ends at {self.end_ms:g} ms and starts at {self.start_ms:g} ms; correct its span")
        outside = spikes[(spikes < self.start_ms) | (spikes > self.end_ms)]
        if outside.size:
            raise ValueError(
                f"{self} reaches from {self.start_ms:g} to {self.end_ms:g} ms, and a spike lies at {outside[0]:g} ms; "
                "correct its span, its event or the unit of the times"
            )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Trial):
            return NotImplemented
        same = self.label == other.label and (self.start_ms, self.end_ms) == (other.start_ms, other.end_ms)
        return same and np.array_equal(self.spikes_ms, other.spikes_ms)

    def __hash__(self) -> int:
        return hash(self.label)

    def __str__(self):
        session = f" of session {self.session!r}" if self.session else ""
        return f"trial {self.name!r}{session} of animal {self.animal!r} ({told(self.condition)})"

    @property
    def label(self) -> tuple[str, str, str, tuple[tuple[str, float | str], ...]]:
        """Animal, session, name and condition: no two trials share them."""
        return self.animal, self.session, self.name, tuple(sorted(self.condition.items()))


def told(condition: Condition) -> str:
    """A condition in words."""
    return ", ".join(
        f"{name} {value:g}" if isinstance(value, float) else f"{name} {value}" for name, value in condition.items()
    )


def natural(text: str) -> tuple[Any, ...]:
    """A key that sorts the numbers within texts by their value."""
    return tuple((0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.findall(r"\d+|\D+", text))
