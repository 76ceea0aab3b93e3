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

_SLACK = 0.02  # of U' at most: an event so near to T_sp is at risk
_CLOSER = 3  # looks at cells around the best so far, each half as far as the one before
_ANYWHERE = 0.2  # how far the first of them goes after the screening, in the unit box
_AFTER_DESCENT = 0.05  # and after a descent
_MOVED = 0.6  # of the pixels' parameters, by chance


@dataclasses.dataclass(frozen=True)
class Candidate:
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
    def of(cls, plain: Mapping[str, Any]) -> "Candidate":
        """The start from plain data, as JSON gives it back."""
        return cls(**{**plain, "z": tuple(plain["z"]), "peaks": tuple(plain["peaks"])})


def risk(candidate: Candidate) -> float:
    """What the best candidate has least of."""
    return candidate.loss


@dataclasses.dataclass(frozen=True)
class Screening:
    """What the screening of a point found.

    - `best`: the candidate at least risk. `best_without`: the same without the events of a source, by its number, among
      cells that were chosen without them too.
    - `count`, `right`: how many cells were drawn, and how many of them were right on all clips.
    - `ends`: lowest and highest values of these, in the unit box; None where none was right.
    """

    best: Candidate
    best_without: Mapping[int, Candidate]
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
    - `left_out`: the events of each source, by its number, without which a choice is made too.
    """

    search: Search[AlarmProblem]
    max_steps: int
    left_out: Mapping[int, Bool[np.ndarray, " event"]]

    def screenings(self, results: Mapping[int, Result]) -> dict[int, Screening]:
        """What `screen` found, from its plain data."""
        return {number: self._screening(plain) for number, plain in results.items()}

    def compile_screening(self) -> None:
        """Judge the cells of one start, so that threads find it compiled."""
        point = self.search.points[0]
        self._best_of(point, sums_at(self.search.space, point), self._cells(0), self._all)

    def screen(self, number: int, stop: Stop) -> Result:
        """Screen a point of the pixels' parameters.

        Its first cells alone tell how many are right: those near the best say nothing of how large the region is.
        """
        point, cells = self.search.points[number], self._cells(number)
        sums = sums_at(self.search.space, point)
        peaks = self._peaks(point, sums, cells)
        best, right = self._best(point, cells, peaks, self._all)
        without = [self._best(point, cells, peaks, ~own)[0] for own in self.left_out.values()]
        region = self._region(point, cells[right], len(cells))
        best = self._closer(best, sums, _ANYWHERE, number, self._all)
        return {**self._plain(best), "without": [dataclasses.asdict(candidate) for candidate in without], **region}

    def near(self, parents: Sequence[Sequence[float]], reach: float, number: int, stop: Stop) -> Result:
        """A point near a parent, with cells near the parent's."""
        parent = np.array(parents[number % len(parents)])
        return self._plain(self._near(parent, reach, number, (number,), self._all))

    def leave_out(self, chosen: Mapping[int, Candidate], reaches: Sequence[float], source: int, stop: Stop) -> Result:
        """The best candidate without a source's events, near the one `chosen` without them: no step sees the source.

        `reaches`: how far, in turn, the pixels of the best so far are moved.
        """
        best, among = chosen[source], ~self.left_out[source]
        best = self._closer(best, sums_at(self.search.space, np.array(best.z)), _ANYWHERE, source, among)
        for turn, reach in enumerate(reaches):
            best = min(best, self._near(np.array(best.z), reach, source, (source, turn), among), key=risk)
        return self._plain(best)

    def descend(self, chosen: Mapping[int, Candidate], number: int, stop: Stop) -> Result:
        """The best candidate that the hard model judged on the way to larger margins."""
        best, z = chosen[number], np.array(chosen[number].z)
        for temperature in self.search.temperatures:
            if stop is not None and stop.is_set():
                break
            descent = self.search.descend(z, temperature, self.max_steps, stop)
            cells = self._around(descent.z, 2 * _AFTER_DESCENT, self._cells(number))
            here = self._closing_in(descent.z, cells, _AFTER_DESCENT, number, self._all)
            best, z = min(best, here, key=risk), np.array(here.z)
        return self._plain(best)

    def _cells(self, number: int) -> Float[np.ndarray, "cell entry"]:
        """Random cells; the given start's own is the first of the first start."""
        cells = self.search.cells(number)
        return cells if number else np.vstack([self.search.points[0, list(self.search.cell_entries)], cells[1:]])

    @property
    def _all(self) -> Bool[np.ndarray, " event"]:
        return np.ones(len(self.search.space.events), bool)

    def _near(
        self,
        parent: Float[np.ndarray, " free"],
        reach: float,
        number: int,
        draw: tuple[int, ...],
        among: Bool[np.ndarray, " event"],
    ) -> Candidate:
        """The best for some of the events of a point near a parent, with cells near the parent's.

        `draw`: which of all such moves it is.
        """
        chance, pixels = np.random.default_rng([*self.search.seed, *draw]), list(self.search.space.pixel_indices)
        moves = reach * chance.standard_normal(len(pixels)) * (chance.random(len(pixels)) < _MOVED)
        point = parent.copy()
        point[pixels] = np.clip(parent[pixels] + moves, 0, 1)
        cells = self._around(parent, 2 * reach, self._cells(number))
        return self._closing_in(point, cells, reach, number, among)

    def _closing_in(
        self,
        point: Float[np.ndarray, " free"],
        cells: Float[np.ndarray, "cell entry"],
        radius: float,
        number: int,
        among: Bool[np.ndarray, " event"],
    ) -> Candidate:
        """The best of these cells on the sums of a point's pixels, and of others ever closer around it."""
        sums = sums_at(self.search.space, point)
        best, _ = self._best_of(point, sums, cells, among)
        return self._closer(best, sums, radius, number, among)

    def _closer(
        self, best: Candidate, sums: tuple[Sums, ...], radius: float, number: int, among: Bool[np.ndarray, " event"]
    ) -> Candidate:
        """The best of cells around a candidate, ever closer, on the sums of its pixels."""
        for closer in range(_CLOSER):
            around = self._around(np.array(best.z), radius / 2**closer, self.search.cells(number, closer))
            best = min(best, self._best_of(np.array(best.z), sums, around, among)[0], key=risk)
        return best

    def _plain(self, best: Candidate) -> Result:
        return {"best": dataclasses.asdict(best), "loss": best.loss}

    def _screening(self, plain: Result) -> Screening:
        without = map(Candidate.of, plain["without"])
        by_source = dict(zip(self.left_out, without, strict=True))
        return Screening(Candidate.of(plain["best"]), by_source, plain["count"], plain["right"], plain["ends"])

    def _peaks(
        self, point: Float[np.ndarray, " free"], sums: tuple[Sums, ...], cells: Float[np.ndarray, "cell entry"]
    ) -> Float[np.ndarray, "cell event"]:
        return np.asarray(peaks_of(self.search.space, point, sums, cells))

    def _best_of(
        self,
        point: Float[np.ndarray, " free"],
        sums: tuple[Sums, ...],
        cells: Float[np.ndarray, "cell entry"],
        among: Bool[np.ndarray, " event"],
    ) -> tuple[Candidate, Bool[np.ndarray, " cell"]]:
        return self._best(point, cells, self._peaks(point, sums, cells), among)

    def _best(
        self,
        point: Float[np.ndarray, " free"],
        cells: Float[np.ndarray, "cell entry"],
        peaks: Float[np.ndarray, "cell event"],
        among: Bool[np.ndarray, " event"],
    ) -> tuple[Candidate, Bool[np.ndarray, " cell"]]:
        """The best cell for some of the events; and which cells are right on all of these."""
        problem = self.search.space
        parameter = problem.free.parameters[problem.threshold]
        wanted, weights = problem.wanted[among], problem.weights[among]
        choice = choose(peaks[:, among], wanted, weights, parameter.low, parameter.high, _SLACK)
        place, z = int(choice.risk.argmin()), np.array(point)
        z[list(problem.cell_entries)] = cells[place]
        z[problem.threshold] = float(parameter.place(choice.threshold[place]))
        best = Candidate(
            z=tuple(z.tolist()),
            peaks=tuple(peaks[place].tolist()),
            loss=float(choice.risk[place]),
            threshold=float(choice.threshold[place]),
            cost=float(choice.cost[place]),
            margin=float(choice.margin[place]),
        )
        return best, choice.cost == 0

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
