"""What a detector did on clips, as counts, and the shares and rates that follow with their intervals."""

import dataclasses
import math
from typing import NamedTuple

import numpy as np
import scipy
from jaxtyping import Float, Int

from lgmd2jax._reports.interval import Interval as Share


class Score(NamedTuple):
    """Windows hit, and false alarms a minute, over all clips."""

    hits: Share
    false_alarms: Share

    def __str__(self):
        percent = Share(*(100 * value for value in self.hits))
        return f"hits {percent} % of the windows, {self.false_alarms} false alarms a minute"


@dataclasses.dataclass(frozen=True)
class Counts:
    """For each clip how many windows were hit of how many, and how many false alarms there were in how many minutes."""

    hits: Int[np.ndarray, " clip"]
    windows: Int[np.ndarray, " clip"]
    false_alarms: Int[np.ndarray, " clip"]
    minutes: Float[np.ndarray, " clip"]

    def score(self) -> Score:
        """Hits with Wilson's interval, false alarms with Garwood's of a Poisson count."""
        hits, windows, false = int(self.hits.sum()), int(self.windows.sum()), int(self.false_alarms.sum())
        share = Share(math.nan, 0.0, 1.0)
        if windows:
            interval = scipy.stats.binomtest(hits, windows).proportion_ci(method="wilson")
            share = Share(hits / windows, float(interval.low), float(interval.high))
        minutes = float(self.minutes.sum()) or math.nan
        low = scipy.stats.chi2.ppf(0.025, 2 * false) / 2 if false else 0.0
        high = scipy.stats.chi2.ppf(0.975, 2 * false + 2) / 2
        return Score(share, Share(false / minutes, float(low) / minutes, float(high) / minutes))
