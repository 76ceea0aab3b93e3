"""Times of several calls in one run, so that what disturbs the machine disturbs them all alike."""

import dataclasses
import math
import statistics
import time
from collections.abc import Callable, Mapping


@dataclasses.dataclass(frozen=True)
class Timing:
    """What calling something takes, in seconds.

    - `compile`: what the first call took longer than a later one.
    - `rounds`: the mean over the calls of each round.
    """

    compile: float
    rounds: tuple[float, ...]

    @property
    def median(self) -> float:
        return statistics.median(self.rounds)

    @property
    def least(self) -> float:
        """Of the round that was disturbed least."""
        return min(self.rounds)

    def over(self, other: "Timing") -> float:
        """How many times as long as `other` of the same run: the median of the ratios in each round."""
        return statistics.median(mine / its for mine, its in zip(self.rounds, other.rounds, strict=True))


def time_together(
    calls: Mapping[str, Callable[[], object]],
    rounds: int,
    at_least: float = 0.02,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, Timing]:
    """Time each of the calls once a round, one after the other.

    **Arguments:** `at_least`: seconds that a turn lasts; what is shorter is called several times. A call must return
    only when its work is done.
    """

    def seconds(call, times=1):
        began = clock()
        for _ in range(times):
            call()
        return (clock() - began) / times

    first = {name: seconds(call) for name, call in calls.items()}
    second = {name: seconds(call) for name, call in calls.items()}
    times = {name: max(math.ceil(at_least / max(duration, 1e-9)), 1) for name, duration in second.items()}
    table = [{name: seconds(call, times[name]) for name, call in calls.items()} for _ in range(rounds)]
    return {name: Timing(max(first[name] - second[name], 0.0), tuple(row[name] for row in table)) for name in calls}
