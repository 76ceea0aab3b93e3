"""How well robots did: collisions per metre and the share of the floor they came to, with intervals over arenas."""

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float, Int

from lgmd2jax._arguments.checked import checked
from lgmd2jax._reports.interval import Interval
from lgmd2jax.arena._drive import Trip
from lgmd2jax.arena._layout import SIDE_CM, Layout

CELL_CM = 5.0  # about the robot
_RESAMPLES, _ENDS = 4000, (2.5, 97.5)  # percentiles
_CELLS = round(SIDE_CM / CELL_CM)


@dataclasses.dataclass(frozen=True)
class Outcome:
    """What a detector's robots did, one in each arena.

    - `contacts`, `alarms`: how many there were. `metres`: how far the robot drove.
    - `share_visited`: of the floor's free cells of 5 cm, how many the robot's centre came to.
    """

    contacts: Int[np.ndarray, " arena"]
    alarms: Int[np.ndarray, " arena"]
    metres: Float[np.ndarray, " arena"]
    share_visited: Float[np.ndarray, " arena"]

    @classmethod
    @checked
    def of(cls, layouts: Sequence[Layout], trips: Trip) -> "Outcome":
        """The outcome of the trips that `run` returns together with their layouts."""
        places = np.asarray(trips.pose.place)
        return cls(
            np.asarray(trips.contact).sum(axis=1),
            np.asarray(trips.alarm).sum(axis=1),
            np.asarray(trips.driven_cm, float).sum(axis=1) / 100,
            np.array([share_visited(layout, place) for layout, place in zip(layouts, places, strict=True)]),
        )

    @property
    def collisions_per_metre(self) -> Interval:
        """Contacts a metre, all arenas together, with the 95 % interval over arenas."""
        return _bootstrap(len(self.metres), self._rate)

    @property
    def coverage(self) -> Interval:
        """The share of the free floor's cells that a robot visits in a trip, the mean over arenas with its interval."""
        return _bootstrap(len(self.metres), self._visited)

    @checked
    def collisions_by(self, other: "Outcome") -> Interval:
        """Collisions per metre, divided by those of another detector in the same arenas; NaN where neither has any."""
        return _bootstrap(len(self.metres), lambda arenas: self._rate(arenas) / other._rate(arenas))

    @checked
    def coverage_by(self, other: "Outcome") -> Interval:
        """Coverage, divided by that of another detector in the same arenas."""
        return _bootstrap(len(self.metres), lambda arenas: self._visited(arenas) / other._visited(arenas))

    def _rate(self, arenas):
        return self.contacts[arenas].sum(axis=-1) / self.metres[arenas].sum(axis=-1)

    def _visited(self, arenas):
        return self.share_visited[arenas].mean(axis=-1)


def share_visited(layout: Layout, places: Float[np.ndarray, "time 2"]) -> float:
    """Of the cells whose middle is free for the robot's centre, the share that it came to."""
    middle = (np.arange(_CELLS) + 0.5) * CELL_CM
    free = layout.free(np.stack(np.meshgrid(middle, middle, indexing="ij"), axis=-1))
    visited = np.zeros_like(free)
    visited[tuple((places // CELL_CM).astype(int).T)] = True
    return float((visited & free).sum() / free.sum())


def _bootstrap(count: int, statistic: Callable[[np.ndarray], np.ndarray]) -> Interval:
    """The statistic of arenas by number, and its interval where arenas are drawn with replacement."""
    drawn = np.random.default_rng(0).integers(count, size=(_RESAMPLES, count))
    with np.errstate(divide="ignore", invalid="ignore"):
        value, resampled = statistic(np.arange(count)), statistic(drawn)
    known = resampled[np.isfinite(resampled)]
    low, high = np.percentile(known, _ENDS) if known.size else (np.nan, np.nan)
    return Interval(float(value), float(low), float(high))
