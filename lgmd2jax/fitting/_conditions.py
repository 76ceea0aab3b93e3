"""Conditions as a fit needs them: rendered, with their targets at the frames."""

import dataclasses
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from typing_extensions import TypeAliasType

from lgmd2jax._protocol.condition import Condition, Protocol
from lgmd2jax._targets.target import AnyTarget, Target
from lgmd2jax.stimuli import Stimulus

# A condition of a protocol, or a stimulus with its target or targets.
AnyCondition = TypeAliasType("AnyCondition", Condition | tuple[Stimulus, AnyTarget | Sequence[AnyTarget]])


class Rendered(NamedTuple):
    """A stimulus with its targets at its frames."""

    stimulus: Stimulus
    targets: list[Target]


def render(conditions: Sequence[AnyCondition]) -> list[Rendered]:
    """Render the stimuli and bring their targets to their frames; stimuli without a name of their own are numbered.

    **Raises:** `ValueError` for no conditions, for what is none, for one without targets, and for targets that do not
    fit their stimulus.
    """
    if isinstance(conditions, Protocol):
        raise ValueError("conditions is a protocol; give its conditions, protocol.conditions")
    if not isinstance(conditions, Sequence):
        raise ValueError(f"conditions is of type {type(conditions).__name__}; give a list of them")
    if not conditions:
        raise ValueError("conditions is empty; give at least one stimulus with a target")
    pairs = [_render(condition, number) for number, condition in enumerate(conditions, start=1)]
    common = {name for name, count in Counter(stimulus.name for stimulus, _ in pairs).items() if count > 1 or not name}
    return [
        Rendered(dataclasses.replace(stimulus, name=f"{stimulus.name or 'condition'} {number}"), targets)
        if stimulus.name in common
        else Rendered(stimulus, targets)
        for number, (stimulus, targets) in enumerate(pairs, start=1)
    ]


def pair_of(condition: AnyCondition, number: int) -> tuple[Stimulus, Sequence[AnyTarget]]:
    """The stimulus of a condition, rendered, and its targets as they are given.

    **Arguments:** `number`: of the condition, in messages.

    **Raises:** `ValueError` for what is no condition.
    """
    if isinstance(condition, Condition):
        stimulus, targets = condition.render(), condition.targets
    elif isinstance(condition, Sequence) and len(condition) == 2 and isinstance(condition[0], Stimulus):
        stimulus, targets = condition
    else:
        kind = type(condition).__name__
        raise ValueError(f"condition {number} is of type {kind}; give a condition, or a stimulus with its targets")
    if isinstance(targets, Sequence):
        return stimulus, targets
    return stimulus, [] if targets is None else [targets]


def _render(condition: AnyCondition, number: int) -> Rendered:
    if isinstance(condition, Rendered):
        return condition
    stimulus, targets = pair_of(condition, number)
    name = stimulus.name or f"number {number}"
    for target in targets:
        if not isinstance(target, AnyTarget) or isinstance(target, type):
            kind = type(target).__name__
            raise ValueError(f"condition {name!r} has a target of type {kind}; give a Target, or what becomes one")
    if not targets:
        raise ValueError(f"condition {name!r} has no target; give it one, or leave it out")
    try:
        rows = [target.on(stimulus) for target in targets]
        for row in rows:
            _ = row.scale  # refuses an error of 0
        return Rendered(stimulus, rows)
    except ValueError as error:
        raise ValueError(f"condition {name!r}: {error}") from error
