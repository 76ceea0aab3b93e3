"""The fit of alarms: a search on two levels, descents from the best, and of what is right the widest margin."""

import dataclasses
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._compute.tasks import Memory, Stop, Work
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.thresholds import Hard
from lgmd2jax._targets.observation import Observation
from lgmd2jax.alarms._choice import Choice, choose
from lgmd2jax.alarms._footage import Footage
from lgmd2jax.alarms._problem import AlarmProblem, problem_of
from lgmd2jax.alarms._reel import Sums
from lgmd2jax.alarms._result import AlarmFit, Descended
from lgmd2jax.alarms._search import look, seen
from lgmd2jax.alarms._watch import watch
from lgmd2jax.fitting import _descent
from lgmd2jax.fitting._fit import ATOL, RTOL, TEMPERATURES, check_counts
from lgmd2jax.fitting._free import Free
from lgmd2jax.fitting._search import sobol, starting_points, words_of
from lgmd2jax.fitting._solver.levenberg_marquardt import BoundedLevenbergMarquardt

if TYPE_CHECKING:
    from distributed import Client

_SLACK = 0.02  # of U': an event so near to T_sp is at risk
_CLOSER = 3  # looks at cells around the best so far, each half as far as the one before
_ANYWHERE = 0.2  # how far the first of them goes after a look anywhere, in the unit box
_DESCENDED = 0.05  # and after a descent
_PARENTS = 8  # of a generation
_REACH = 0.1  # of the first generation; each of the next goes half as far
_MOVED = 0.6  # of the pixels' parameters, by chance
_LEFT_OUT = 32  # clips at most, for each of which the choice is made anew without it


def fit(
    model: LGMD2,
    clips: Sequence[Footage],
    free: Free,
    *,
    key: Array,
    miss: float | int = 1.0,
    false_alarm: float | int = 1.0,
    pixel_points: int = 128,
    cell_points: int = 256,
    generations: int = 4,
    descend: int = 4,
    temperatures: Sequence[float | int] = TEMPERATURES,
    max_steps: int = 20,
    progress: bool = False,
    memory: Memory | None = None,
    client: "Client | None" = None,
) -> AlarmFit:
    """Fit a model's free parameters to labelled clips: alarms in every window, none in a silence.

    For each of the `pixel_points` all clips are seen once; `cell_points` cells are tried on what the pixels summed,
    then as many around the best, ever closer; of each the best T_sp is known exactly. The neighbourhood of the best
    points is searched in the same way, generation by generation. The best are descended on soft thresholds, towards
    larger margins, with searches of the cell between; every candidate is judged by the hard model. What is at least
    risk is handed over: of what is right on all clips that with the widest margin, by which T_sp may move, in units of
    U', before a verdict changes.

    **Arguments:**

    - `model`: what stays fixed, and the values from which the search sets out. Its N_sp and N_ts are kept.
    - `clips`: those of `load_footage`, or your own by `footage`.
    - `free`: which parameters may change, within which bounds; T_sp is always among them.
    - `key`: of the search's random points. The same key gives the same fit.
    - `miss`, `false_alarm`: what it costs to miss a window, and to break the silence of a clip.
    - `pixel_points`, `cell_points`, `descend`, `temperatures`, `max_steps`: as for `lgmd2jax.fit`.
    - `generations`: of the search near the best, each a quarter of the pixel points; 0 for none, as for `descend`.
    - `progress`: show a bar.
    - `memory`: a mapping that keeps finished work; given again, the fit goes on from there.
    - `client`: of a Dask cluster, on whose workers the starts are spread instead of on the cores here.

    **Raises:** `ValueError` for no clips, for clips in which no alarm is wanted, for a start outside of its bounds, and
    for numbers that make no sense.
    """
    _check(model, clips, {"miss": miss, "false_alarm": false_alarm})
    check_counts({"pixel_points": pixel_points, "cell_points": cell_points, "max_steps": max_steps}, at_least=1)
    check_counts({"generations": generations, "descend": descend}, at_least=0)
    model = dataclasses.replace(model, thresholds=Hard())
    if "T_sp" not in free.names:
        free = free.also(T_sp=None)
    problem = problem_of(model, free, clips, float(miss), float(false_alarm))
    start = free.place(model.parameters, Observation())
    seed = words_of(key)
    points = starting_points(problem, start, pixel_points, seed)
    solver = BoundedLevenbergMarquardt(RTOL, ATOL, lower=0.0, upper=1.0)
    groups = _groups(problem, len(clips))
    starts = _Starts(problem, points, groups, cell_points, seed, tuple(map(float, temperatures)), solver, max_steps)
    with Work({} if memory is None else memory, progress, client) as work:
        screened = work.do("screening", starts.screen, range(len(points)), starts.compile)
        if not screened:
            raise KeyboardInterrupt
        anywhere = tuple(screened.values())  # what is near the best says nothing of how large the region is
        for generation in range(generations):
            parents = [it["best"][0]["z"] for it in sorted(screened.values(), key=_risk)[:_PARENTS]]
            task = partial(starts.near, parents, _REACH / 2**generation)
            count = max(1, pixel_points // 4)
            screened |= work.do(f"generation {generation + 1}", task, range(len(screened), len(screened) + count))
        ranked = sorted(screened, key=lambda number: _risk(screened[number]))[:descend]
        chosen = {number: screened[number]["best"][0] for number in ranked}
        one_step = partial(_descent.solve, problem, start, starts.temperatures[0], solver, 1)
        descended = work.do("descending", partial(starts.descend, chosen), ranked, one_step)
        stopped = work.stop.is_set()
    candidates = [*(it["best"][0] for it in screened.values()), *(it["after"] for it in descended.values())]
    best = min(candidates, key=_risk)
    parameters, _ = free.insert(model.parameters, Observation(), np.array(best["z"]))
    chosen = dataclasses.replace(model, parameters=parameters)
    left_out = {}
    for place, group in enumerate(groups[1:], start=1):
        entry = min((it["best"][place] for it in screened.values()), key=_risk)
        wrong = _errors(problem, entry, ~group)
        left_out[clips[problem.events[int(np.flatnonzero(~group)[0])].clip].name] = wrong
    return AlarmFit(
        model=chosen,
        free=free,
        z=np.array(best["z"]),
        cost=best["cost"],
        margin=best["margin"],
        watch=watch(chosen, clips),
        screened=sum(it["count"] for it in anywhere),
        right=sum(it["right"] for it in anywhere),
        ranges=_ranges(problem, anywhere),
        descended=tuple(
            Descended(number, screened[number]["best"][0]["margin"], it["after"]["margin"], it["after"]["cost"])
            for number, it in descended.items()
        ),
        left_out=left_out,
        stopped=stopped,
    )


@dataclasses.dataclass(frozen=True)
class _Starts:
    """What is to be done with a start by its number, wherever that is.

    `groups`: of events, all of them and those but for each clip, for each of which a choice is made.
    """

    problem: AlarmProblem
    points: np.ndarray
    groups: list[np.ndarray]
    cell_points: int
    seed: tuple[int, ...]
    temperatures: tuple[float, ...]
    solver: BoundedLevenbergMarquardt
    max_steps: int

    def cells(self, number: int) -> Float[np.ndarray, "cell searched"]:
        """Drawn by chance; the start's own is among the first."""
        drawn = sobol(len(self.problem.searched), self.cell_points, (*self.seed, number))
        return np.vstack([self.points[0, list(self.problem.searched)], drawn[1:]]) if number == 0 else drawn

    def compile(self) -> None:
        """What every start needs, by one look."""
        self._choose_among(self.points[0], seen(self.problem, self.points[0]), self.cells(0))

    def screen(self, number: int, stop: Stop) -> dict[str, Any]:
        """A point of the pixels' parameters, anywhere."""
        return self._closing_in(self.points[number], self.cells(number), _ANYWHERE, number)

    def near(self, parents: list[list[float]], reach: float, number: int, stop: Stop) -> dict[str, Any]:
        """One near a parent, with cells near the parent's."""
        chance, parent = np.random.default_rng([*self.seed, number]), np.array(parents[number % len(parents)])
        pixels = list(self.problem.pixel_indices)
        moved = reach * chance.standard_normal(len(pixels)) * (chance.random(len(pixels)) < _MOVED)
        point = parent.copy()
        point[pixels] = np.clip(parent[pixels] + moved, 0, 1)
        return self._closing_in(point, self._around(parent, 2 * reach, self.cells(number)), reach, number)

    def descend(self, chosen: dict[int, dict[str, Any]], number: int, stop: Stop) -> dict[str, Any]:
        """From a candidate towards larger margins; the best that the hard model was seen to do."""
        best, z = chosen[number], np.array(chosen[number]["z"])
        for temperature in self.temperatures:
            if stop is not None and stop.is_set():
                break
            z, _, _ = _descent.solve(self.problem, z, temperature, self.solver, self.max_steps, stop)
            cells = self._around(z, 2 * _DESCENDED, self.cells(number))
            here = self._closing_in(z, cells, _DESCENDED, number)["best"][0]
            best, z = min(best, here, key=_risk), np.array(here["z"])
        return {"after": best, "loss": best["loss"]}

    def _closing_in(self, point: np.ndarray, cells: np.ndarray, radius: float, number: int) -> dict[str, Any]:
        """Cells on what the pixels of a point sum up to, then others around the best of them, ever closer.

        The first ones alone tell how many are right: those near the best say nothing of how large the region is.
        """
        sums = seen(self.problem, point)
        best, right = self._choose_among(point, sums, cells)
        region = self._region(point, cells[right], len(cells))
        for closer in range(_CLOSER):
            drawn = sobol(len(self.problem.searched), len(cells), (*self.seed, number, closer))
            near = self._around(np.array(best[0]["z"]), radius / 2**closer, drawn)
            found, _ = self._choose_among(point, sums, near)
            best = [min(pair, key=_risk) for pair in zip(best, found, strict=True)]
        return {"best": best, "loss": best[0]["loss"], **region}

    def _choose_among(
        self, point: np.ndarray, sums: tuple[Sums, ...], cells: np.ndarray
    ) -> tuple[list[dict[str, Any]], np.ndarray]:
        """The best cell for each group of events, and which cells are right on all of them."""
        peaks = np.asarray(look(self.problem, point, sums, cells))
        choices = [_choice(self.problem, peaks, group) for group in self.groups]
        return [_best(self.problem, point, cells, peaks, it) for it in choices], choices[0].cost == 0

    def _around(self, centre: np.ndarray, radius: float, drawn: np.ndarray) -> np.ndarray:
        """Cells within a radius of that of a point, and that one."""
        own = centre[list(self.problem.searched)]
        return np.vstack([own, np.clip(own + radius * (2 * drawn[1:] - 1), 0, 1)])

    def _region(self, point: np.ndarray, cells: np.ndarray, count: int) -> dict[str, Any]:
        """Of how many cells how many are right, and between which values they lie."""
        right = np.tile(point, (len(cells), 1))
        right[:, list(self.problem.searched)] = cells
        ends = [right.min(axis=0).tolist(), right.max(axis=0).tolist()] if len(right) else None
        return {"count": count, "right": len(right), "ends": ends}


def _check(model: LGMD2, clips: Sequence[Footage], weights: dict[str, float | int]) -> None:
    if not clips:
        raise ValueError("clips is empty; give at least one")
    if not any(clip.windows for clip in clips):
        raise ValueError("no clip has a window in which an alarm is wanted; then a model that never fires would do")
    for name, weight in weights.items():
        if not (np.isfinite(weight) and weight > 0):
            raise ValueError(f"{name} is {weight!r}; give a positive weight")
    if float(model.parameters.N_sp) % 1:
        raise ValueError(f"N_sp is {float(model.parameters.N_sp):g}; alarms count whole spikes: give a whole number")


def _groups(problem: AlarmProblem, clips: int) -> list[np.ndarray]:
    """All events, and, of few clips, all but those of each."""
    owners = np.array([event.clip for event in problem.events])
    every = [np.ones(len(owners), bool)]
    return every + [owners != it for it in np.unique(owners)] if 1 < clips <= _LEFT_OUT else every


def _choice(problem: AlarmProblem, peaks: np.ndarray, among: np.ndarray | slice = slice(None)) -> Choice:
    freedom = problem.free.freedoms[problem.threshold]
    bounds = freedom.low, freedom.high
    return choose(peaks[:, among], problem.wanted[among], problem.weights[among], *bounds, _SLACK)


def _best(
    problem: AlarmProblem, point: np.ndarray, cells: np.ndarray, peaks: np.ndarray, choice: Choice
) -> dict[str, Any]:
    """The candidate at least risk, as plain data."""
    place, z = int(choice.risk.argmin()), np.array(point)
    z[list(problem.searched)] = cells[place]
    z[problem.threshold] = float(problem.free.freedoms[problem.threshold].place(choice.threshold[place]))
    numbers = {name: float(getattr(choice, name)[place]) for name in ("threshold", "cost", "margin")}
    return {"z": z.tolist(), "peaks": peaks[place].tolist(), "loss": float(choice.risk[place]), **numbers}


def _risk(result: dict[str, Any]) -> float:
    return result["loss"]


def _errors(problem: AlarmProblem, entry: dict[str, Any], among: np.ndarray) -> int:
    """How many of these events a candidate gets wrong."""
    on = np.array(entry["peaks"]) >= entry["threshold"]
    return int((on != problem.wanted)[among].sum())


def _ranges(problem: AlarmProblem, screened: Sequence[dict[str, Any]]) -> dict[str, tuple[float, float]]:
    """Between which values each parameter lay in the sets that were right on all clips; T_sp is chosen for each."""
    ends = np.array([it["ends"] for it in screened if it["ends"] is not None])
    if not len(ends):
        return {}
    low, high = ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)
    return {
        it.name: (float(it.value(low[i])), float(it.value(high[i])))
        for i, it in enumerate(problem.free.freedoms)
        if i != problem.threshold
    }
