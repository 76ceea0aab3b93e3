"""How well a fit predicts what it has not seen: each condition left out in turn."""

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np

from lgmd2jax._targets.target import Channel, Target
from lgmd2jax.fitting._curve import variance_explained
from lgmd2jax.stimuli import Stimulus

Pair = tuple[Stimulus, Sequence[Target]]


class Predicts(Protocol):
    """What a fit can do."""

    def predict(self, stimulus: Stimulus, channel: Channel, /) -> np.ndarray:
        """The channel at the frames of the stimulus."""
        ...


def leave_one_out(fit_to: Callable[[Sequence[Pair]], Predicts], pairs: Sequence[Pair]) -> dict[str, float]:
    """R2 of each condition's first target, predicted by a fit to all other conditions.

    **Raises:** `ValueError` for fewer than two conditions.
    """
    if len(pairs) < 2:
        raise ValueError("there is one condition only; to leave one out, give two or more")
    explained = {}
    for left_out, (stimulus, (target, *_)) in enumerate(pairs):
        fitted = fit_to([pair for number, pair in enumerate(pairs) if number != left_out])
        predicted = fitted.predict(stimulus, target.channel)
        explained[stimulus.name] = variance_explained(target.values, predicted, target.weight)
    return explained
