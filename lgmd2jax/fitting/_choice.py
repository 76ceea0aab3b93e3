"""The choice between candidates of a fit by what else a model must do, beside the loss."""

from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax.fitting._problem import Problem
from lgmd2jax.fitting._run import Run

_SHARES = (0.25, 0.5, 0.75, 1.0)  # of the line from the start to the end of a descent, at which candidates lie


def chosen_candidate(
    problem: Problem, start: Float[np.ndarray, " free"], runs: Sequence[Run], choose: Callable[[AbstractNetwork], float]
) -> tuple[Float[np.ndarray, " free"], float, dict[str, Any]]:
    """The candidate with the highest score, its loss, and what the choice was between."""
    ends = [np.array(run.z) for run in runs]
    candidates = [start, *(start + share * (end - start) for end in ends for share in _SHARES)]
    losses = [float(_hard_loss(problem, jax.device_put(z))) for z in candidates]
    scores = [_score(choose(problem.at(z)[0])) for z in candidates]
    best = max(range(len(candidates)), key=lambda i: (scores[i], -losses[i]))
    least = int(np.argmin(losses))
    choice = {"candidates": len(candidates), "score": scores[best]}
    choice |= {"least_loss": losses[least], "score_of_least_loss": scores[least]}
    return candidates[best], losses[best], {"choice": choice}


def _score(score: Any) -> float:
    if not (isinstance(score, (int, float, np.generic, np.ndarray, jax.Array)) and np.isfinite(score).all()):
        raise ValueError(f"choose returned {score!r:.60}; let it return a finite number, higher for a better model")
    return float(score)


@traced_once
def _hard_loss(problem: Problem, z: Float[Array, " free"]) -> Float[Array, ""]:
    return 0.5 * jnp.square(problem.residuals(z, None)).sum()
