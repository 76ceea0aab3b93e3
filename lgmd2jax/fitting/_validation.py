"""How well a model predicts what it was not fitted to: each condition, or each family, is left out in turn."""

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


def check_no_bands(pairs: Sequence[Pair]) -> None:
    """Raise `ValueError` where the first target of a condition is a band, of which R2 says nothing."""
    for stimulus, (target, *_) in pairs:
        if target.is_band:
            raise ValueError(f"the target of {stimulus.name!r} is a band, which has no R2; leave leave_one_out out")


def leave_one_out(
    fit_to: Callable[[Sequence[Pair]], Predict], pairs: Sequence[Pair], groups: Sequence[str] | None = None
) -> dict[str, float]:
    """R2 of each condition's first target, predicted by a fit to all conditions of other groups.

    **Arguments:** `fit_to` fits to conditions, and returns what predicts others. `groups`: of each condition, such as
    its family; by default each is one by itself.

    **Raises:** `ValueError` for fewer than two groups, and for a band, of which R2 says nothing.
    """
    labels = range(len(pairs)) if groups is None else groups
    if len(set(labels)) < 2:
        raise ValueError("there is one condition only, or one family; to leave one out, give two or more")
    check_no_bands(pairs)
    explained = {}
    for left_out in dict.fromkeys(labels):
        predict = fit_to([pair for pair, label in zip(pairs, labels, strict=True) if label != left_out])
        for (stimulus, (target, *_)), label in zip(pairs, labels, strict=True):
            if label == left_out:
                curve = predict(stimulus, target.channel)
                explained[stimulus.name] = variance_explained(target.values, curve, target.weight)
    return explained
