"""Conditions as a fit needs them: rendered, with their targets at the frames."""

import dataclasses
from collections import Counter
from collections.abc import Sequence

from lgmd2jax._protocol.protocol import Condition
from lgmd2jax._targets.target import AnyTarget, Target
from lgmd2jax.stimuli import Stimulus

# A condition of a protocol, or a stimulus with its target or targets.
AnyCondition = Condition | tuple[Stimulus, AnyTarget | Sequence[AnyTarget]]


def render(conditions: Sequence[AnyCondition]) -> list[tuple[Stimulus, list[Target]]]:
    """Render the stimuli and bring their targets to their frames; stimuli without a name of their own are numbered.

    **Raises:** `ValueError` for no conditions, for one without targets, and for targets that do not fit their stimulus.
    """
    if not conditions:
        raise ValueError("conditions is empty; give at least one stimulus with a target")
    pairs = [_render(condition, number) for number, condition in enumerate(conditions, start=1)]
    common = {name for name, count in Counter(stimulus.name for stimulus, _ in pairs).items() if count > 1 or not name}
    return [
        (dataclasses.replace(stimulus, name=f"{stimulus.name or 'condition'} {number}"), targets)
        if stimulus.name in common
        else (stimulus, targets)
        for number, (stimulus, targets) in enumerate(pairs, start=1)
    ]


def _render(condition: AnyCondition, number: int) -> tuple[Stimulus, list[Target]]:
    if isinstance(condition, Condition):
        stimulus, targets = condition.render(), condition.targets
    else:
        stimulus, targets = condition
    if not isinstance(targets, Sequence):
        targets = [targets]
    name = stimulus.name or f"number {number}"
    if not targets:
        raise ValueError(f"condition {name!r} has no target; give it one, or leave it out")
    try:
        rows = [target.on(stimulus) for target in targets]
        for row in rows:
            _ = row.scale  # refuses an error of 0
        return stimulus, rows
    except ValueError as error:
        raise ValueError(f"condition {name!r}: {error}") from error
