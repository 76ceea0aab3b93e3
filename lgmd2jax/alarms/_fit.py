"""The fit of alarms: a search on two levels, descents from the best, and of what is right the widest margin."""

import dataclasses
from collections.abc import Sequence
from functools import partial
from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._model import LGMD2
from lgmd2jax._observation import Observation
from lgmd2jax._thresholds import Hard
from lgmd2jax.alarms._choice import Choice, choose
from lgmd2jax.alarms._footage import Footage
from lgmd2jax.alarms._problem import AlarmProblem, problem_of
from lgmd2jax.alarms._result import AlarmFit, Descended
from lgmd2jax.alarms._search import look
from lgmd2jax.alarms._watch import watch
from lgmd2jax.fitting import _descent
from lgmd2jax.fitting._bounded import BoundedLevenbergMarquardt
from lgmd2jax.fitting._free import Free
from lgmd2jax.fitting._search import sobol
from lgmd2jax.fitting._work import Memory, Work

TEMPERATURES = (0.5, 0.2, 0.05)
_RTOL, _ATOL = 3e-3, 1e-8
_RADIUS = 0.05  # of the search around what a descent reached, in the unit box
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
    cell_points: int = 1024,
    descend: int = 4,
    temperatures: Sequence[float | int] = TEMPERATURES,
    max_steps: int = 20,
    progress: bool = False,
    memory: Memory | None = None,
) -> AlarmFit:
    """Fit a model's free parameters to labelled clips: alarms in every window, none in a silence.

    For each of the `pixel_points` all clips are seen once; `cell_points` cells are tried on what the pixels summed, and
    of each the best T_sp is known exactly. The best are descended on soft thresholds, towards larger margins, with
    searches of the cell between; every candidate is judged by the hard model. What errs least is handed over, and of
    that what has the widest margin: T_sp may move by so much, in units of U', before a verdict changes.

    **Arguments:**

    - `model`: what stays fixed, and the values from which the search sets out. Its N_sp and N_ts are kept.
    - `clips`: those of `load_footage`, or your own by `footage`.
    - `free`: which parameters may change, within which bounds; T_sp is always among them.
    - `key`: of the search's random points. The same key gives the same fit.
    - `miss`, `false_alarm`: what it costs to miss a window, and to break the silence of a clip.
    - `pixel_points`, `cell_points`, `descend`, `temperatures`, `max_steps`: as for `lgmd2jax.fit`.
    - `progress`: show a bar.
    - `memory`: a mapping that keeps finished work; given again, the fit goes on from there.

    **Raises:** `ValueError` for no clips, for clips in which no alarm is wanted, for a start outside of its bounds, and
    for numbers that make no sense.
    """
    counts = {"pixel_points": pixel_points, "cell_points": cell_points, "descend": descend, "max_steps": max_steps}
    _check(model, clips, counts, {"miss": miss, "false_alarm": false_alarm})
    model = dataclasses.replace(model, thresholds=Hard())
    if "T_sp" not in free.names:
        free = free.also(T_sp=None)
    problem = problem_of(model, free, clips, float(miss), float(false_alarm))
    start = free.place(model.parameters, Observation())
    seed = tuple(int(word) for word in np.ravel(jax.random.key_data(key)))
    points = _points(problem, start, pixel_points, seed)
    solver = BoundedLevenbergMarquardt(_RTOL, _ATOL, lower=0.0, upper=1.0)
    groups = _groups(problem, len(clips))

    with Work({} if memory is None else memory, progress) as work:

        def cells(number: int) -> Float[np.ndarray, "cell searched"]:
            drawn = sobol(len(problem.searched), cell_points, (*seed, number))
            return np.vstack([points[number, list(problem.searched)], drawn]) if number == 0 else drawn

        def screen(number: int) -> dict[str, Any]:
            tried = cells(number)
            peaks = np.asarray(look(problem, points[number], tried))
            choice = _choice(problem, peaks)
            best = []
            for group in groups:
                chosen = choice if group.all() else _choice(problem, peaks, group)
                first = int(chosen.order()[0])
                best.append(_entry(problem, points[number], tried[first], peaks[first], chosen, first))
            right = tried[choice.cost == 0]
            work.saw(best[0]["cost"], number)
            return {"best": best, "count": len(tried), "right": len(right), "ends": _ends(right)}

        def run(number: int) -> dict[str, Any]:
            return _descend(problem, screened[number]["best"][0], cells(number), solver, temperatures, max_steps, work)

        first = partial(look, problem, points[0], cells(min(1, len(points) - 1)))
        screened = work.do("screening", screen, range(len(points)), first)
        if not screened:
            raise KeyboardInterrupt
        ranked = sorted(screened, key=lambda number: _rank(screened[number]["best"][0]))[:descend]
        descended = work.do(
            "descending", run, ranked, partial(_descent.solve, problem, start, temperatures[0], solver, 1)
        )
        stopped = work.stop.is_set()
    candidates = [screened[ranked[0]]["best"][0], *(it["after"] for it in descended.values())]
    best = min(candidates, key=_rank)
    parameters, _ = free.insert(model.parameters, Observation(), np.array(best["z"]))
    chosen = dataclasses.replace(model, parameters=parameters)
    left_out = {}
    for place, group in enumerate(groups[1:], start=1):
        entry = min((it["best"][place] for it in screened.values()), key=_rank)
        wrong = _errors(problem, entry, ~group)
        left_out[clips[problem.events[int(np.flatnonzero(~group)[0])].clip].name] = wrong
    return AlarmFit(
        model=chosen,
        free=free,
        z=np.array(best["z"]),
        cost=best["cost"],
        margin=best["margin"],
        watch=watch(chosen, clips),
        screened=sum(it["count"] for it in screened.values()),
        right=sum(it["right"] for it in screened.values()),
        ranges=_ranges(problem, points, screened),
        descended=tuple(
            Descended(number, screened[number]["best"][0]["margin"], it["after"]["margin"], it["after"]["cost"])
            for number, it in descended.items()
        ),
        left_out=left_out,
        stopped=stopped,
    )


def _check(model: LGMD2, clips: Sequence[Footage], counts: dict[str, int], weights: dict[str, float | int]) -> None:
    if not clips:
        raise ValueError("clips is empty; give at least one")
    if not any(clip.windows for clip in clips):
        raise ValueError("no clip has a window in which an alarm is wanted; then a model that never fires would do")
    for name, count in counts.items():
        if not isinstance(count, int) or count < 1:
            raise ValueError(f"{name} is {count!r}; give a whole number, 1 or more")
    for name, weight in weights.items():
        if not (np.isfinite(weight) and weight > 0):
            raise ValueError(f"{name} is {weight!r}; give a positive weight")
    if float(model.parameters.N_sp) % 1:
        raise ValueError(f"N_sp is {float(model.parameters.N_sp):g}; alarms count whole spikes: give a whole number")


def _points(problem: AlarmProblem, start: np.ndarray, count: int, seed: tuple[int, ...]) -> np.ndarray:
    """The start, then points that differ from it in what the pixels need."""
    points = np.repeat(start[None], count, axis=0)
    pixels = list(problem.pixel_indices)
    points[1:, pixels] = sobol(len(pixels), count, seed)[: count - 1]
    return points


def _groups(problem: AlarmProblem, clips: int) -> list[np.ndarray]:
    """All events, and, of few clips, all but those of each."""
    owners = np.array([event.clip for event in problem.events])
    every = [np.ones(len(owners), bool)]
    return every + [owners != it for it in np.unique(owners)] if 1 < clips <= _LEFT_OUT else every


def _choice(problem: AlarmProblem, peaks: np.ndarray, among: np.ndarray | slice = slice(None)) -> Choice:
    freedom = problem.free.freedoms[problem.threshold]
    return choose(peaks[:, among], problem.wanted[among], problem.weights[among], freedom.low, freedom.high)


def _entry(
    problem: AlarmProblem, point: np.ndarray, cell: np.ndarray, peaks: np.ndarray, choice: Choice, place: int
) -> dict[str, Any]:
    """A candidate as plain data."""
    z = np.array(point)
    z[list(problem.searched)] = cell
    z[problem.threshold] = float(problem.free.freedoms[problem.threshold].place(choice.threshold[place]))
    numbers = {"cost": float(choice.cost[place]), "margin": float(choice.margin[place])}
    return {"z": z.tolist(), "peaks": peaks.tolist(), "threshold": float(choice.threshold[place]), **numbers}


def _rank(entry: dict[str, Any]) -> tuple[float, float]:
    return entry["cost"], -entry["margin"]


def _errors(problem: AlarmProblem, entry: dict[str, Any], among: np.ndarray) -> int:
    """How many of these events a candidate gets wrong."""
    on = np.array(entry["peaks"]) >= entry["threshold"]
    return int((on != problem.wanted)[among].sum())


def _descend(
    problem: AlarmProblem,
    before: dict[str, Any],
    cells: np.ndarray,
    solver: BoundedLevenbergMarquardt,
    temperatures: Sequence[float | int],
    max_steps: int,
    work: Work,
) -> dict[str, Any]:
    """From a candidate towards larger margins; the best that the hard model was seen to do."""
    best, z = before, np.array(before["z"])
    for temperature in temperatures:
        if work.stop.is_set():
            break
        z, _, _ = _descent.solve(problem, z, float(temperature), solver, max_steps, work.stop)
        own = z[list(problem.searched)]
        tried = np.vstack([own, np.clip(own + 2 * _RADIUS * (cells - 0.5), 0, 1)])
        peaks = np.asarray(look(problem, z, tried))
        choice = _choice(problem, peaks)
        first = int(choice.order()[0])
        here = _entry(problem, z, tried[first], peaks[first], choice, first)
        best, z = min(best, here, key=_rank), np.array(here["z"])
    return {"after": best}


def _ends(right: np.ndarray) -> list[list[float]] | None:
    return [right.min(axis=0).tolist(), right.max(axis=0).tolist()] if len(right) else None


def _ranges(problem: AlarmProblem, points: np.ndarray, screened: dict[int, Any]) -> dict[str, tuple[float, float]]:
    """Between which values each parameter lay in the sets that were right on all clips."""
    low, high = np.full(len(problem.free), np.inf), np.full(len(problem.free), -np.inf)
    pixels, searched = list(problem.pixel_indices), list(problem.searched)
    for number, it in screened.items():
        if it["ends"] is not None:
            low[pixels], high[pixels] = (
                np.minimum(low, points[number])[pixels],
                np.maximum(high, points[number])[pixels],
            )
            low[searched] = np.minimum(low[searched], it["ends"][0])
            high[searched] = np.maximum(high[searched], it["ends"][1])
    return {
        freedom.name: (float(freedom.value(low[i])), float(freedom.value(high[i])))
        for i, freedom in enumerate(problem.free.freedoms)
        if np.isfinite(low[i])
    }
