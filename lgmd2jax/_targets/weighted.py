"""How much a target counts, and when."""

import dataclasses
import math

import numpy as np

from lgmd2jax._arguments.checked import checked
from lgmd2jax._targets.target import AnyTarget, Target, check_correlation
from lgmd2jax.stimuli import Stimulus


@checked
@dataclasses.dataclass(frozen=True)
class Weighted:
    """Any target, given another error or weight, or a window outside of which it does not count.

    ```python
    Weighted(Rest("smp_adapted"), weight=2, from_ms=300)
    ```

    **Arguments:**

    - `target`: whatever becomes a target on a stimulus.
    - `error`: standard error by which a difference is divided, in the unit of the channel, instead of the target's own.
    - `weight`: factor of the squared difference, times the target's own.
    - `from_ms`, `until_ms`: the window in which it counts, ends included; None reaches to the end of the stimulus.
    - `correlation_ms`: the span that makes one independent sample, instead of the target's own.

    **Raises:** `ValueError` for numbers that are negative or not finite, an error of 0, and a window without extent.
    """

    target: AnyTarget
    error: float | int | None = None
    weight: float | int = 1.0
    from_ms: float | int | None = None
    until_ms: float | int | None = None
    correlation_ms: float | int | None = None

    def __post_init__(self):
        if self.error is not None and not (math.isfinite(self.error) and self.error > 0):
            raise ValueError(f"error is {self.error}; give a positive number")
        if not (math.isfinite(self.weight) and self.weight >= 0):
            raise ValueError(f"weight is {self.weight}; give 0 or more")
        start, end = self._window
        if not start <= end:
            raise ValueError(f"from_ms is {self.from_ms} and until_ms {self.until_ms}; the window must have an extent")
        if self.correlation_ms is not None:
            check_correlation(self.correlation_ms)

    @checked
    def on(self, stimulus: Stimulus) -> Target:
        """The target at the frames of the stimulus, with weight 0 outside of the window.

        **Raises:** `ValueError` for a window that holds no frame, and what the target itself raises.
        """
        target = self.target.on(stimulus)
        time, (start, end) = np.asarray(stimulus.time, dtype=float), self._window
        inside = (time >= start) & (time <= end)
        if not np.any(target.weight * inside) and np.any(target.weight):
            raise ValueError(
                f"from_ms {start:g} to until_ms {end:g} holds no frame that counts; "
                f"the stimulus covers {time[0]:g} to {time[-1]:g} ms"
            )
        changes = {"error": self.error, "correlation_ms": self.correlation_ms}
        return dataclasses.replace(
            target,
            weight=target.weight * self.weight * inside,
            **{name: value for name, value in changes.items() if value is not None},
        )

    @property
    def _window(self) -> tuple[float, float]:
        start = -math.inf if self.from_ms is None else float(self.from_ms)
        end = math.inf if self.until_ms is None else float(self.until_ms)
        return start, end
