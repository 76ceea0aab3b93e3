"""The tasks of a fit of alarms, each about one start: screen a point or one near it, descend towards larger margins."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from lgmd2jax._compute.tasks import Result, Stop
from lgmd2jax.alarms._cell_search import peaks_of, sums_at
from lgmd2jax.alarms._choice import choose
from lgmd2jax.alarms._clip_batch import Sums
from lgmd2jax.alarms._problem import AlarmProblem
from lgmd2jax.fitting._search.search import Search

_SLACK = 0.02  # of U': an event so near to T_sp is at risk
_CLOSER = 3  # looks at cells around the best so far, each half as far as the one before
_ANYWHERE = 0.2  # how far the first of them goes after a look anywhere, in the unit box
_AFTER_DESCENT = 0.05  # and after a descent
_MOVED = 0.6  # of the pixels' parameters, by chance


@dataclasses.dataclass(frozen=True)
class Contender:
    """A point of the unit box with the T_sp that suits it best, as the hard model judges it.

    - `z`: the point, T_sp included. `threshold`: T_sp. `peaks`: the largest evidence in each event.
    - `loss`: the risk. `cost`, `margin`: as in `Choice`.
    """

    z: tuple[float, ...]
    peaks: tuple[float, ...]
    loss: float
    threshold: float
    cost: float
    margin: float

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> "Contender":
        """From plain data, as JSON gives it back."""
        return cls(**{**plain, "z": tuple(plain["z"]), "peaks": tuple(plain["peaks"])})

    def errors(self, problem: AlarmProblem, among: Bool[np.ndarray, " event"]) -> int:
        """How many of these events go wrong."""
        on = np.array(self.peaks) >= self.threshold
        return int((on != problem.wanted)[among].sum())


def risk(contender: Contender) -> float:
    """What the best contender has least of."""
    return contender.loss


@dataclasses.dataclass(frozen=True)
class Screening:
    """What became of a start.

    - `best`: the contender at least risk. `best_without`: the same without the events of a clip, by its number.
    - `count`, `right`: how many cells were tried anywhere, and how many of them were right on all clips.
    - `ends`: lowest and highest values of these, in the unit box; None where none was right.
    """

    best: Contender
    best_without: Mapping[int, Contender]
    count: int
    right: int
    ends: Sequence[Sequence[float]] | None


class AlarmDescent(NamedTuple):
    """One start: its number, the margin by the search and the one after the descent, and the cost after it."""

    start: int
    before: float
    after: float
    cost: float


@dataclasses.dataclass(frozen=True)
class AlarmStarts:
    """Each task takes the number of its start, and returns plain data with the risk as `loss`.

    - `max_steps`: of the solver, at each temperature.
    - `left_out`: the events of each clip, by its number, without which a choice is made too.
    """

    search: Search[AlarmProblem]
    max_steps: int
    left_out: Mapping[int, Bool[np.ndarray, " event"]]

    def screenings(self, results: Mapping[int, Result]) -> dict[int, Screening]:
        """What `screen` and `near` found, from their plain data."""
        return {number: self._screening(plain) for number, plain in results.items()}

    def compile_screening(self) -> None:
        """Judge the cells of one start, so that threads find it compiled."""
        point = self.search.points[0]
        self._best_of(point, sums_at(self.search.space, point), self._cells(0))

    def screen(self, number: int, stop: Stop) -> Result:
        """A point of the pixels' parameters, anywhere."""
        return self._closing_in(self.search.points[number], self._cells(number), _ANYWHERE, number)

    def near(self, parents: Sequence[Sequence[float]], reach: float, number: int, stop: Stop) -> Result:
        """A point near a parent, with cells near the parent's."""
        chance, parent = np.random.default_rng([*self.search.seed, number]), np.array(parents[number % len(parents)])
        pixels = list(self.search.space.pixel_indices)
        moves = reach * chance.standard_normal(len(pixels)) * (chance.random(len(pixels)) < _MOVED)
        point = parent.copy()
        point[pixels] = np.clip(parent[pixels] + moves, 0, 1)
        return self._closing_in(point, self._around(parent, 2 * reach, self._cells(number)), reach, number)

    def descend(self, chosen: Mapping[int, Contender], number: int, stop: Stop) -> Result:
        """The best contender that the hard model judged on the way to larger margins."""
        best, z = chosen[number], np.array(chosen[number].z)
        for temperature in self.search.temperatures:
            if stop is not None and stop.is_set():
                break
            descent = self.search.descend(z, temperature, self.max_steps, stop)
            cells = self._around(descent.z, 2 * _AFTER_DESCENT, self._cells(number))
            here = self._screening(self._closing_in(descent.z, cells, _AFTER_DESCENT, number)).best
            best, z = min(best, here, key=risk), np.array(here.z)
        return {"after": dataclasses.asdict(best), "loss": best.loss}

    def _cells(self, number: int) -> Float[np.ndarray, "cell entry"]:
        """Random cells; the given start's own is the first of the first start."""
        cells = self.search.cells(number)
        return cells if number else np.vstack([self.search.points[0, list(self.search.cell_entries)], cells[1:]])

    def _closing_in(
        self, point: Float[np.ndarray, " free"], cells: Float[np.ndarray, "cell entry"], radius: float, number: int
    ) -> Result:
        """Cells on the sums of a point's pixels, then others around the best of them, ever closer.

        The first ones alone tell how many are right: those near the best say nothing of how large the region is.
        """
        sums = sums_at(self.search.space, point)
        best, right = self._best_of(point, sums, cells)
        region = self._region(point, cells[right], len(cells))
        for closer in range(_CLOSER):
            around = self._around(np.array(best[0].z), radius / 2**closer, self.search.cells(number, closer))
            contenders, _ = self._best_of(point, sums, around)
            best = [min(pair, key=risk) for pair in zip(best, contenders, strict=True)]
        return {"best": [dataclasses.asdict(contender) for contender in best], "loss": best[0].loss, **region}

    def _screening(self, plain: Result) -> Screening:
        best, *without = map(Contender.of, plain["best"])
        by_clip = dict(zip(self.left_out, without, strict=True))
        return Screening(best, by_clip, plain["count"], plain["right"], plain["ends"])

    def _best_of(
        self, point: Float[np.ndarray, " free"], sums: tuple[Sums, ...], cells: Float[np.ndarray, "cell entry"]
    ) -> tuple[list[Contender], Bool[np.ndarray, " cell"]]:
        """The best cell for all events, then without those of each clip; and which cells are right on all events."""
        problem = self.search.space
        peaks = np.asarray(peaks_of(problem, point, sums, cells))
        freedom = problem.free.freedoms[problem.threshold]
        events = [np.ones(len(problem.events), bool), *(~own for own in self.left_out.values())]
        choices = [
            choose(peaks[:, among], problem.wanted[among], problem.weights[among], freedom.low, freedom.high, _SLACK)
            for among in events
        ]
        contenders = []
        for choice in choices:
            place, z = int(choice.risk.argmin()), np.array(point)
            z[list(problem.cell_entries)] = cells[place]
            z[problem.threshold] = float(freedom.place(choice.threshold[place]))
            contenders.append(
                Contender(
                    z=tuple(z.tolist()),
                    peaks=tuple(peaks[place].tolist()),
                    loss=float(choice.risk[place]),
                    threshold=float(choice.threshold[place]),
                    cost=float(choice.cost[place]),
                    margin=float(choice.margin[place]),
                )
            )
        return contenders, choices[0].cost == 0

    def _around(
        self, centre: Float[np.ndarray, " free"], radius: float, cells: Float[np.ndarray, "cell entry"]
    ) -> Float[np.ndarray, "cell entry"]:
        """The cell of a point, and others within a radius of it."""
        own = centre[list(self.search.cell_entries)]
        return np.vstack([own, np.clip(own + radius * (2 * cells[1:] - 1), 0, 1)])

    def _region(
        self, point: Float[np.ndarray, " free"], cells: Float[np.ndarray, "right entry"], count: int
    ) -> dict[str, Any]:
        """Of how many cells how many are right, and between which values they lie."""
        right = np.tile(point, (len(cells), 1))
        right[:, list(self.search.cell_entries)] = cells
        ends = [right.min(axis=0).tolist(), right.max(axis=0).tolist()] if len(right) else None
        return {"count": count, "right": len(right), "ends": ends}
