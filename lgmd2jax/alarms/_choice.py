"""The threshold that suits a set of clips best: where it errs least, and there as far as possible from erring."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float


class Choice(NamedTuple):
    """For each candidate: the T_sp, the weight of what it gets wrong, and how far T_sp may move up and down.

    `margin` is half the gap in which T_sp changes no verdict, in units of U'.
    """

    threshold: Float[np.ndarray, " candidate"]
    cost: Float[np.ndarray, " candidate"]
    margin: Float[np.ndarray, " candidate"]

    def order(self) -> np.ndarray:
        """The candidates, the best first: of least cost, and among these of the largest margin."""
        return np.lexsort((-self.margin, self.cost))


def choose(
    peaks: Float[np.ndarray, "candidate event"],
    wanted: Bool[np.ndarray, " event"],
    weights: Float[np.ndarray, " event"],
    low: float,
    high: float,
) -> Choice:
    """The best T_sp in [low, high] of each candidate, exactly: the threshold needs no search.

    **Arguments:** `peaks`: the largest evidence in each event, which is a window in which an alarm is `wanted`, or all
    that must be silent of a clip. `weights`: what it costs to miss it, or to give a false alarm there.
    """
    inside = np.clip(peaks, low, high)
    order = np.argsort(inside, axis=1, kind="stable")
    hit = wanted[order]
    weight = weights[order]
    # Below the threshold lie missed windows and clips that are rightly silent.
    none = np.zeros((len(peaks), 1))
    cost = np.hstack([none, np.cumsum(np.where(hit, weight, -weight), axis=1)]) + weights[~wanted].sum()
    levels = np.hstack([none + low, np.take_along_axis(inside, order, axis=1), none + high])
    gap = np.diff(levels, axis=1)
    # Where two peaks are equal no threshold lies between them, nor outside of the bounds.
    cost = np.where(gap > 0, cost, np.inf)
    best = np.argmax(np.where(cost <= cost.min(axis=1, keepdims=True), gap, -1.0), axis=1)[:, None]
    lower, width = (np.take_along_axis(it, best, axis=1)[:, 0] for it in (levels[:, :-1], gap))
    return Choice(lower + width / 2, np.take_along_axis(cost, best, axis=1)[:, 0], width / 2)
