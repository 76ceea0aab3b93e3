"""The fit: screening on two levels, descents from the best, the choice by the model's own loss, the uncertainty."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Array

from lgmd2jax._compute.tasks import Memory, Stop, Work
from lgmd2jax._network.abstract import Network
from lgmd2jax._network.thresholds import Soft, StraightThrough
from lgmd2jax._targets.observation import Observation, observation_symbols
from lgmd2jax._words import nearest
from lgmd2jax.fitting import _descent
from lgmd2jax.fitting._conditions import Given, Rendered, rendered
from lgmd2jax.fitting._descent import ENDED, STOPPED, Run, Solver
from lgmd2jax.fitting._free import Free
from lgmd2jax.fitting._outcome import outcome
from lgmd2jax.fitting._problem import Problem, problem_of
from lgmd2jax.fitting._result import Fit
from lgmd2jax.fitting._robust import LOSSES, Loss
from lgmd2jax.fitting._search import search_cell, sobol, starting_points, words_of
from lgmd2jax.fitting._solver.levenberg_marquardt import BoundedLevenbergMarquardt

if TYPE_CHECKING:
    from distributed import Client

TEMPERATURES = (0.5, 0.2, 0.05)
# Of the residuals' norm: what is left to fall is then the square of it, far below what curves can tell.
RTOL, ATOL = 3e-3, 1e-8
_FURTHER = 5  # times the steps of all others, for the best descent to converge
_APART = 0.02  # in the unit box; starts closer to a better one are not descended


def fit(
    model: Network,
    conditions: Sequence[Given],
    free: Free,
    *,
    key: Array,
    observation: Observation | None = None,
    temperatures: Sequence[float | int] | None = None,
    pixel_points: int = 128,
    cell_points: int = 1024,
    descend: int = 4,
    loss: Loss = "squares",
    solver: Solver | None = None,
    max_steps: int = 60,
    absolute_errors: bool | None = None,
    throw: bool = False,
    progress: bool = False,
    memory: Memory | None = None,
    client: "Client | None" = None,
) -> Fit:
    """Fit a model's free parameters to target curves.

    The model is fitted as it is: one with hard thresholds by descents on soft ones whose temperature falls, and the
    best *hard* candidate is the result; one with soft thresholds at its own temperature.

    **Arguments:**

    - `model`: what stays fixed, and the values from which the search sets out.
    - `conditions`: those of a protocol, or pairs of a stimulus with its target or targets.
    - `free`: which parameters may change, within which bounds.
    - `key`: of the search's random points. The same key gives the same fit.
    - `observation`: how a `rate` arises from the potential.
    - `temperatures`: of the descent, falling; by default .5, .2, .05, or that of a soft model.
    - `pixel_points`: points of the parameters that the pixels need; `cell_points`: of those of the cell, for each.
    - `descend`: how many of the best points are descended.
    - `loss`: `"squares"`, or `"huber"`, `"soft_l1"`, `"cauchy"`, which outliers cannot pull far.
    - `solver`: any optimistix least-squares solver or minimiser; by default the bounded Levenberg-Marquardt.
    - `max_steps`: of the solver at the last temperature; at those before, 20 suffice. The best descent gets five times
      as many to converge.
    - `absolute_errors`: whether the targets' errors are believed as they are; by default where all targets have them.
      Otherwise they are weights, and the residual variance sets the scale of all uncertainty.
    - `throw`: whether to raise `RuntimeError` where the result is not `"converged"`.
    - `progress`: show a bar with the best loss so far.
    - `memory`: a mapping that keeps finished work; given again, the fit goes on from there.
    - `client`: of a Dask cluster, on whose workers the starts are spread instead of on the cores here.

    On Ctrl-C the best so far is returned; its `result` says so. Fits want float64: `jax_enable_x64`.

    **Raises:** `ValueError` for conditions without targets, for a start outside of its bounds, for more free parameters
    than independent samples, for a prior beside targets without errors, and for settings that make no sense.
    """
    pairs, observation, free = rendered(conditions), observation or Observation(), free.of(type(model.parameters))
    temperatures = _temperatures(model, temperatures)
    counts = {"pixel_points": pixel_points, "cell_points": cell_points, "descend": descend, "max_steps": max_steps}
    _check(pairs, free, loss, counts)
    problem = problem_of(model, observation, free, pairs, loss)
    samples = problem.samples()
    if samples < len(free):
        raise ValueError(
            f"{len(free)} parameters are free, but the targets hold only {samples:.3g} independent samples; "
            "fix some, or add data"
        )
    start = free.place(model.parameters, observation)
    seed = words_of(key)
    points = starting_points(problem, start, pixel_points, seed)
    solver = solver or BoundedLevenbergMarquardt(RTOL, ATOL, lower=0.0, upper=1.0)

    starts = _Starts(problem, points, cell_points, seed, temperatures, solver, max_steps)
    with Work({} if memory is None else memory, progress, client) as work:
        # The first calls compile, alone, before the threads need what they compile.
        first = partial(search_cell, problem, points[0], starts.cells(0))
        screened = work.do("screening", starts.screen, range(len(points)), first)
        if not screened:
            raise KeyboardInterrupt
        chosen = _apart(screened, descend)
        if not chosen:
            raise ValueError("no point of the search gave a finite loss; narrow the bounds of free, or fix its targets")
        one_step = partial(_descent.solve, problem, points[0], temperatures[0], solver, 1)
        descended = work.do("descending", partial(starts.descend, screened), chosen, one_step)
        best = min(descended, key=lambda number: descended[number]["loss"], default=None)
        if best is not None and descended[best]["result"] not in ENDED:
            descended |= work.do("finishing", partial(starts.finish, descended), [best])
        runs, stopped = [Run.of(it) for it in descended.values()], work.stop.is_set()
    runs = sorted(runs, key=lambda it: it.loss) or [_not_run(screened[chosen[0]])]
    result = STOPPED if stopped else runs[0].result
    if throw and result not in ENDED:
        raise RuntimeError(f"the fit did not converge: {result}; see fit(..., throw=False)")
    return outcome(
        problem,
        pairs,
        runs=tuple(runs),
        screened=tuple(sorted(it["loss"] for it in screened.values())),
        start=start,
        temperatures=temperatures,
        absolute_errors=absolute_errors,
        result=result,
        stats={"pixel_points": pixel_points, "cell_points": cell_points, "loss": loss, "seed": list(seed)},
    )


@dataclass(frozen=True)
class _Starts:
    """What is to be done with a start by its number, wherever that is."""

    problem: Problem
    points: np.ndarray
    cell_points: int
    seed: tuple[int, ...]
    temperatures: tuple[float, ...]
    solver: Solver
    max_steps: int

    def cells(self, number: int) -> np.ndarray:
        return sobol(len(self.problem.cell_indices), self.cell_points, (*self.seed, number))

    def screen(self, number: int, stop: Stop) -> dict[str, Any]:
        found = search_cell(self.problem, self.points[number], self.cells(number))
        return {"z": np.asarray(found.z).tolist(), "loss": float(found.loss)}

    def descend(self, screened: dict[int, dict[str, Any]], number: int, stop: Stop) -> dict[str, Any]:
        begun = _descent.begin(self.problem, np.array(screened[number]["z"]), self.cells(number))
        return self._go_on(begun, number, self.temperatures, self.max_steps, stop)

    def finish(self, descended: dict[int, dict[str, Any]], number: int, stop: Stop) -> dict[str, Any]:
        run = Run.of(descended[number])
        return self._go_on(run, number, self.temperatures[-1:], _FURTHER * self.max_steps, stop)

    def _go_on(self, run: Run, number: int, temperatures: tuple[float, ...], max_steps: int, stop: Stop):
        how: dict[str, Any] = {"temperatures": temperatures, "solver": self.solver, "max_steps": max_steps}
        return asdict(_descent.descend(self.problem, run, self.cells(number), **how, stop=stop))


def _temperatures(model: Network, temperatures) -> tuple[float, ...]:
    if temperatures is None:
        own = model.thresholds
        temperatures = [own.temperature] if isinstance(own, Soft | StraightThrough) else TEMPERATURES
    temperatures = tuple(float(it) for it in temperatures)
    if not temperatures or not all(np.isfinite(it) and it > 0 for it in temperatures):
        raise ValueError(f"temperatures is {temperatures}; give one or more positive numbers")
    if any(after >= before for before, after in pairwise(temperatures)):
        raise ValueError(f"temperatures is {temperatures}; let them fall")
    return temperatures


def check_counts(counts: dict[str, int], at_least: int) -> None:
    """Raise `ValueError` for the first that is no whole number, or too small."""
    for name, count in counts.items():
        if not isinstance(count, int) or count < at_least:
            raise ValueError(f"{name} is {count!r}; give a whole number, {at_least} or more")


def _check(pairs: Sequence[Rendered], free: Free, loss: str, counts: dict[str, int]) -> None:
    if loss not in LOSSES:
        raise ValueError(f"loss is {loss!r}; choose {nearest(loss, LOSSES)}")
    check_counts(counts, at_least=1)
    targets = [target for _, targets in pairs for target in targets]
    unseen = [name for name in free.names if name in observation_symbols()]
    if unseen and not any(target.channel == "rate" for target in targets):
        raise ValueError(f"{unseen[0]} is free, but no target is a rate, which alone depends on it; fix it")
    beforehand = [it.name for it in free.freedoms if it.prior]
    if beforehand and not all(target.has_error for target in targets):
        raise ValueError(
            f"{beforehand[0]} has a prior, which can only be weighed against data of known error; give targets an error"
        )


def _apart(screened: dict[int, dict[str, Any]], count: int) -> list[int]:
    """The best points that are not near a better one."""
    chosen: list[int] = []
    for number in sorted(screened, key=lambda i: screened[i]["loss"]):
        z = np.array(screened[number]["z"])
        if all(np.abs(z - screened[other]["z"]).max() > _APART for other in chosen):
            chosen.append(number)
        if len(chosen) == count:
            break
    return chosen


def _not_run(point: dict[str, Any]) -> Run:
    z, loss = tuple(point["z"]), point["loss"]
    return Run(z, z, loss, loss, float("inf"), (), STOPPED)
