"""How well a model predicts a condition that it was not fitted to: each is left out in turn."""

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float

from lgmd2jax._channels import Channel
from lgmd2jax._targets.target import Target
from lgmd2jax.fitting._curve import variance_explained
from lgmd2jax.stimuli import Stimulus

Pair = tuple[Stimulus, Sequence[Target]]
# A channel of the response to a stimulus, at its frames.
Predict = Callable[[Stimulus, Channel], Float[np.ndarray, " time"]]
# What fits to conditions, and returns what predicts others.
FitTo = Callable[[Sequence[Pair]], Predict]


def check_no_bands(pairs: Sequence[Pair]) -> None:
    """Raise `ValueError` where the first target of a condition is a band, of which R2 says nothing."""
    for stimulus, (target, *_) in pairs:
        if target.is_band:
            raise ValueError(f"the target of {stimulus.name!r} is a band, which has no R2; leave leave_one_out out")


def leave_one_out(fit_to: FitTo, pairs: Sequence[Pair]) -> dict[str, float]:
    """R2 of each condition's first target, predicted by a fit to all other conditions.

    **Raises:** `ValueError` for fewer than two conditions.
    """
    return {stimulus.name: predicted_r2(fit_to, pairs, number) for number, (stimulus, _) in enumerate(pairs)}


def predicted_r2(fit_to: FitTo, pairs: Sequence[Pair], left_out: int) -> float:
    """R2 of the first target of the condition with this number, predicted by a fit to all other conditions.

    **Raises:** `ValueError` for fewer than two conditions, and for a band, of which R2 says nothing.
    """
    if len(pairs) < 2:
        raise ValueError("there is one condition only; to leave one out, give two or more")
    check_no_bands(pairs)
    stimulus, (target, *_) = pairs[left_out]
    predict = fit_to([pair for number, pair in enumerate(pairs) if number != left_out])
    return variance_explained(target.values, predict(stimulus, target.channel), target.weight)
