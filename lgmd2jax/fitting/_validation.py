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
# What fits to conditions, and returns what predicts others.
FitTo = Callable[[Sequence[Pair]], Predict]


def check_no_bands(pairs: Sequence[Pair]) -> None:
    """Raise `ValueError` where the first target of a condition is a band, of which R2 says nothing."""
    for stimulus, (target, *_) in pairs:
        if target.is_band:
            raise ValueError(f"the target of {stimulus.name!r} is a band, which has no R2; leave leave_one_out out")


def leave_one_out(fit_to: FitTo, pairs: Sequence[Pair], groups: Sequence[str] | None = None) -> dict[str, float]:
    """R2 of each condition's first target, predicted by a fit to all conditions of other groups.

    **Arguments:** `groups`: of each condition, such as its family; by default each is one by itself.

    **Raises:** `ValueError` for fewer than two groups, and for a band, of which R2 says nothing.
    """
    groups = [str(number) for number in range(len(pairs))] if groups is None else groups
    explained = [predicted_r2(fit_to, pairs, groups, left_out) for left_out in dict.fromkeys(groups)]
    return {name: r2 for group in explained for name, r2 in group.items()}


def predicted_r2(fit_to: FitTo, pairs: Sequence[Pair], groups: Sequence[str], left_out: str) -> dict[str, float]:
    """R2 of the first target of each condition of one group, predicted by a fit to all conditions of the others.

    **Raises:** `ValueError` as `leave_one_out`.
    """
    if len(set(groups)) < 2:
        raise ValueError("there is one condition only, or one family; to leave one out, give two or more")
    check_no_bands(pairs)
    labelled = list(zip(pairs, groups, strict=True))
    predict = fit_to([pair for pair, group in labelled if group != left_out])
    return {
        stimulus.name: variance_explained(target.values, predict(stimulus, target.channel), target.weight)
        for (stimulus, (target, *_)), group in labelled
        if group == left_out
    }
