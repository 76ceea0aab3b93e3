"""The threshold that suits a set of clips best: where the least is at risk."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.special import expit

_COARSE, _FINE = 81, 21  # thresholds looked at between the bounds, then between the neighbours of the best
_NARROW = 0.1  # of the deviation of a candidate's evidence over the events, which may lie close together


class Choice(NamedTuple):
    """For each candidate the best T_sp, and what it does.

    - `risk`: the weight of all events, each by a logistic share that is 1/2 at T_sp, 0 far on its right side and 1 far
      on its wrong one.
    - `cost`: the weight of what is wrong. `margin`: how far T_sp may move before a verdict changes, in units of U'.
    """

    threshold: Float[np.ndarray, " candidate"]
    risk: Float[np.ndarray, " candidate"]
    cost: Float[np.ndarray, " candidate"]
    margin: Float[np.ndarray, " candidate"]


def choose(
    peaks: Float[np.ndarray, "candidate event"],
    wanted: Bool[np.ndarray, " event"],
    weights: Float[np.ndarray, " event"],
    low: float,
    high: float,
    slack: float,
) -> Choice:
    """The T_sp of least risk in [low, high] of each candidate: the threshold needs no search.

    A candidate that is correct on all clips is at risk by its worst events, so that the least risk has the widest
    margin. Where no candidate is correct, an event close to T_sp counts for half.

    **Arguments:** `peaks`: the largest evidence in each event, which is a window in which an alarm is `wanted`, or all
    that must be silent of a clip. `weights`: what it costs to miss it, or to give a false alarm there. `slack`: the
    scale of the logistic at most, in units of U'; it is less where a candidate's evidence lies close together.
    """
    side, weights_ = np.where(wanted, -1.0, 1.0).astype(np.float32), weights.astype(np.float32)
    scale = np.clip(_NARROW * peaks.std(axis=1, keepdims=True), 1e-6, slack).astype(np.float32)
    scaled = peaks.astype(np.float32)

    def risk(threshold):
        return expit(side * (scaled - np.reshape(threshold, (-1, 1)).astype(np.float32)) / scale) @ weights_

    coarse = np.linspace(low, high, _COARSE)
    best = coarse[np.argmin([risk(threshold) for threshold in coarse], axis=0)]
    fine = np.clip(best + np.linspace(-1, 1, _FINE)[:, None] * (coarse[1] - coarse[0]), low, high)
    risks = np.array([risk(row) for row in fine])
    place = risks.argmin(axis=0)[None]
    threshold = np.take_along_axis(fine, place, axis=0)[0]
    wrong = (peaks >= threshold[:, None]) != wanted
    margin = np.abs(peaks - threshold[:, None]).min(axis=1)
    return Choice(threshold, np.take_along_axis(risks, place, axis=0)[0].astype(float), wrong @ weights, margin)
