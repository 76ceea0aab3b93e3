"""Which stimulus to record next: the one whose curves narrow the intervals most."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from lgmd2jax.fitting._uncertainty.covariance import BOX_VARIANCE, Uncertainty


class Candidate(NamedTuple):
    """A stimulus that might be recorded.

    - `gain`: in the log-determinant of the information (D-optimality). One unit multiplies the volume of the confidence
      region by exp(-1/2), .61; halving takes 2 ln 2, 1.39.
    - `shrink`: by which factor the standard error of each parameter would become smaller.
    """

    name: str
    gain: float
    shrink: dict[str, float]


def rank(u: Uncertainty, jacobians: Sequence[Float[np.ndarray, "_ free"]], names: Sequence[str]) -> list[Candidate]:
    """Rank the stimuli, the best first. `jacobians`: slopes of their curves by the unit box, in standard errors."""
    before = u.information + np.eye(len(u.names)) / BOX_VARIANCE
    errors = np.sqrt(np.diag(np.linalg.inv(before)))
    candidates = []
    for name, jacobian in zip(names, jacobians, strict=True):
        after = before + jacobian.T @ jacobian
        gain = np.linalg.slogdet(after)[1] - np.linalg.slogdet(before)[1]
        shrink = np.sqrt(np.diag(np.linalg.inv(after))) / errors
        candidates.append(Candidate(name, float(gain), dict(zip(u.names, shrink.tolist(), strict=True))))
    return sorted(candidates, key=lambda candidate: -candidate.gain)
