"""What a detector did on clips, as counts, and the shares and rates that follow with their intervals."""

import dataclasses
import math
from typing import NamedTuple

import numpy as np
import scipy
from jaxtyping import Float, Int

from lgmd2jax._reports.interval import Interval as Share


class Score(NamedTuple):
    """The share of windows hit, 0 to 1, and the false alarms a minute, over all clips, with 95 % intervals."""

    hits: Share
    false_alarms: Share

    def __str__(self):
        percent = Share(*(100 * value for value in self.hits))
        return f"hits {percent} % of the windows, {self.false_alarms} false alarms a minute"


@dataclasses.dataclass(frozen=True)
class Counts:
    """Counts of each clip: windows hit, of how many, and false alarms, in how many minutes of wanted silence."""

    hits: Int[np.ndarray, " clip"]
    windows: Int[np.ndarray, " clip"]
    false_alarms: Int[np.ndarray, " clip"]
    minutes: Float[np.ndarray, " clip"]

    def score(self) -> Score:
        """Hits with Wilson's interval, false alarms a minute with Garwood's of a Poisson count."""
        hits, windows, false = int(self.hits.sum()), int(self.windows.sum()), int(self.false_alarms.sum())
        share = Share(math.nan, 0.0, 1.0)
        if windows:
            interval = scipy.stats.binomtest(hits, windows).proportion_ci(method="wilson")
            share = Share(hits / windows, float(interval.low), float(interval.high))
        minutes = float(self.minutes.sum()) or math.nan
        low = scipy.stats.chi2.ppf(0.025, 2 * false) / 2 if false else 0.0
        high = scipy.stats.chi2.ppf(0.975, 2 * false + 2) / 2
        return Score(share, Share(false / minutes, float(low) / minutes, float(high) / minutes))
