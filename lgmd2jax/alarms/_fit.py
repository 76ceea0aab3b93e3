"""The fit of alarms: a search on two levels, descents from the best, and of what is right the widest margin."""

import dataclasses
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Array

from lgmd2jax._arguments.checked import checked
from lgmd2jax._compute.fingerprint import fingerprint
from lgmd2jax._compute.finished_work import Memory
from lgmd2jax._compute.tasks import Result, Work
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.thresholds import Hard
from lgmd2jax._targets.observation import Observation
from lgmd2jax._types import check_key
from lgmd2jax.alarms._clip import LabelledClip
from lgmd2jax.alarms._evaluation import evaluate
from lgmd2jax.alarms._problem import AlarmProblem, problem_of
from lgmd2jax.alarms._result import AlarmFit
from lgmd2jax.alarms._starts import AlarmDescent, AlarmStarts, Candidate, Screening, risk
from lgmd2jax.fitting import Free
from lgmd2jax.fitting._search.search import TEMPERATURES, Search, check_counts

if TYPE_CHECKING:
    from distributed import Client

_PARENTS = 8  # of a generation
_REACH = 0.1  # of the first generation, in the unit box; each of the next goes half as far
_LEFT_OUT = 32  # sources at most, each of which is left out once


@checked
def fit(
    model: LGMD2,
    clips: Sequence[LabelledClip],
    free: Free,
    *,
    key: Array,
    miss: float | int = 1.0,
    false_alarm: float | int = 1.0,
    recorded: float | int | None = None,
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

    ```python
    labels = lgmd.alarms.load_labels("mine.toml")
    model, free = lgmd.LGMD2(eye=labels.eye), lgmd.Free(k=None, tau1=None, T_ffi=(5, 50))
    fit = lgmd.alarms.fit(model, labels.load(), free, key=jax.random.key(0))
    print(fit.summary())
    ```

    For each of the `pixel_points` the pixels of all clips are computed once. On their sums `cell_points` cells are
    tried, then as many around the best, ever closer; for each cell the best T_sp is known exactly. The neighbourhood of
    the best points is searched in the same way, generation by generation. The best are descended on soft thresholds,
    towards larger margins, with searches of the cell between; every candidate is judged by the hard model. The one at
    least risk is handed over: among those that are right on all clips the one with the widest margin, by which T_sp may
    move, in units of U', before a verdict changes.

    **Arguments:**

    - `model`: what stays fixed, and the values from which the search sets out. Its N_sp and N_ts are kept.
    - `clips`: those of `load_labels`, or your own by `LabelledClip.of`.
    - `free`: which parameters may change, within which bounds; T_sp is always among them.
    - `key`: of the search's random points. The same key gives the same fit.
    - `miss`, `false_alarm`: the cost of a missed window, and of false alarms in a clip, or in each five seconds or so
      of a long one.
    - `recorded`: what all recorded clips, those that have a source, weigh together, as a multiple of the rendered ones;
      by default each error counts alike, times the weight of its clip.
    - `pixel_points`, `cell_points`, `descend`, `temperatures`, `max_steps`: as for `lgmd2jax.fit`.
    - `generations`: of the search near the best, each a quarter of the pixel points; it and `descend` may be 0.
    - `progress`: show a bar.
    - `memory`: a mapping, such as a dict, that keeps finished work; given again, the fit goes on from there. That of
      another fit is refused.
    - `client`: of a Dask cluster, on whose workers the starts are spread instead of on the cores here.

    On Ctrl-C the best so far is returned. Before the first start is finished the `KeyboardInterrupt` goes on to the
    caller.

    **Raises:** `ValueError` for no clips, for clips in which no alarm is wanted, for a start outside of its bounds, for
    the memory of another fit, and for numbers that make no sense.
    """
    check_key(key)
    _check(model, clips, {"miss": miss, "false_alarm": false_alarm, "recorded": 1 if recorded is None else recorded})
    check_counts({"pixel_points": pixel_points, "cell_points": cell_points, "max_steps": max_steps}, at_least=1)
    check_counts({"generations": generations, "descend": descend}, at_least=0)
    model = dataclasses.replace(model, thresholds=Hard())
    if "T_sp" not in free.names:
        free = free.also(T_sp=None)
    problem = problem_of(
        model, free, clips, float(miss), float(false_alarm), None if recorded is None else float(recorded)
    )
    search = Search.of(
        problem,
        problem.cell_entries,
        free.place(model.parameters, Observation()),
        key=key,
        pixel_points=pixel_points,
        cell_points=cell_points,
        temperatures=tuple(map(float, temperatures)),
    )
    sources = _sources(clips)
    events_of = dict(enumerate(problem.events_of(numbers) for numbers in sources.values()))
    events_of = {i: own for i, own in events_of.items() if own.any() and not own.all()}
    events_of = events_of if len(events_of) <= _LEFT_OUT else {}
    starts = AlarmStarts(search, max_steps, events_of)
    children = max(1, pixel_points // 4)
    total = pixel_points + generations * children + min(descend, pixel_points) + len(events_of)
    digest = "" if memory is None else fingerprint((starts, generations))
    with Work({} if memory is None else memory, progress, client, digest=digest, total=total) as work:
        screenings = starts.screenings(
            work.do("screening", starts.screen, range(pixel_points), starts.compile_screening)
        )
        best = {number: screening.best for number, screening in screenings.items()}
        for generation in range(generations):
            parents = sorted(best.values(), key=risk)[:_PARENTS]
            task = partial(starts.near, [parent.z for parent in parents], _REACH / 2**generation)
            numbers = range(len(best), len(best) + children)
            best |= _candidates(work.do(f"generation {generation + 1}", task, numbers))
        chosen = sorted(best, key=lambda number: risk(best[number]))[:descend]
        task = partial(starts.descend, {number: best[number] for number in chosen})
        descents = _candidates(work.do("descending", task, chosen, search.compile_descent))
        # Generations and descents saw all clips: a choice without a source begins with the screened points.
        without = {
            source: min((screening.best_without[source] for screening in screenings.values()), key=risk)
            for source in events_of
        }
        task = partial(starts.leave_out, without, [_REACH / 2**generation for generation in range(generations)])
        left_out = _candidates(work.do("leaving out", task, events_of))
        stopped = work.stop.is_set()
    winner = min([*best.values(), *descents.values()], key=risk)
    names, fitted = list(sources), _model_at(model, free, winner)
    return AlarmFit(
        model=fitted,
        free=free,
        z=np.array(winner.z),
        cost=winner.cost,
        margin=winner.margin,
        evaluation=evaluate(fitted, clips),
        screened=sum(screening.count for screening in screenings.values()),
        right=sum(screening.right for screening in screenings.values()),
        ranges=_ranges(problem, tuple(screenings.values())),
        descended=tuple(
            AlarmDescent(number, best[number].margin, after.margin, after.cost) for number, after in descents.items()
        ),
        without={
            names[source]: evaluate(_model_at(model, free, candidate), clips) for source, candidate in left_out.items()
        },
        stopped=stopped,
    )


def _sources(clips: Sequence[LabelledClip]) -> dict[str, list[int]]:
    """The numbers of the clips of each source."""
    sources: dict[str, list[int]] = {}
    for number, clip in enumerate(clips):
        if clip.source is not None:
            sources.setdefault(clip.source, []).append(number)
    return sources


def _model_at(model: LGMD2, free: Free, candidate: Candidate) -> LGMD2:
    """The model with the parameters of a candidate."""
    parameters, _ = free.insert(model.parameters, Observation(), np.array(candidate.z))
    return dataclasses.replace(model, parameters=parameters)


def _candidates(results: Mapping[int, Result]) -> dict[int, Candidate]:
    """The best of each task, from its plain data."""
    return {number: Candidate.of(plain["best"]) for number, plain in results.items()}


def _check(model: LGMD2, clips: Sequence[LabelledClip], weights: dict[str, float | int]) -> None:
    if not clips:
        raise ValueError("clips is empty; give at least one")
    if not any(clip.windows for clip in clips):
        raise ValueError("no clip has a window, in which an alarm is wanted; give at least one")
    for name, weight in weights.items():
        if not (np.isfinite(weight) and weight > 0):
            raise ValueError(f"{name} is {weight!r}; give a positive weight")
    if float(model.parameters.N_sp) % 1:
        raise ValueError(f"N_sp is {float(model.parameters.N_sp):g}; an alarm counts spikes: give a whole number")


def _ranges(problem: AlarmProblem, screenings: Sequence[Screening]) -> dict[str, tuple[float, float]]:
    """Between which values each parameter lay in the sets that were right on all clips; T_sp is chosen for each."""
    ends = np.array([screening.ends for screening in screenings if screening.ends is not None])
    if not len(ends):
        return {}
    low, high = ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)
    return {
        parameter.name: (float(parameter.value(low[i])), float(parameter.value(high[i])))
        for i, parameter in enumerate(problem.free.parameters)
        if i != problem.threshold
    }
