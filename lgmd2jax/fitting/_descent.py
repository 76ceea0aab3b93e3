"""One start's way down: the temperature falls step by step, and between steps the cell is searched anew."""

import dataclasses
import threading
from collections.abc import Mapping, Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Float

from lgmd2jax.fitting._problem import Problem
from lgmd2jax.fitting._search import search_cell
from lgmd2jax.fitting._solver.levenberg_marquardt import BoundedLevenbergMarquardt
from lgmd2jax.fitting._space import Space

Solver = optx.AbstractLeastSquaresSolver | optx.AbstractMinimiser
# Near the hard end the loss is a fine staircase, on which no gradient vanishes: enough when it hardly falls.
_PATIENCE, _FALL = 20, 1e-3
FLAT = f"flat: the loss fell by less than {_FALL:.1%} in {_PATIENCE} steps"
STOPPED = "stopped by hand"
ENDED = ("converged", FLAT)  # what a descent that need not go on says
_ON_THE_WAY = 20  # steps at a temperature that is not the last: it only has to lead there
_EDGE = 1e-3  # a solver without bounds starts at least so far from them, in the unit box


@dataclasses.dataclass(frozen=True)
class Run:
    """What became of one start.

    - `start`, `z`: first and best point in the unit box.
    - `start_loss`, `loss`: of the model with its own thresholds at these points.
    - `soft_loss`: at the last temperature, where the descent ended.
    - `history`: loss after every step, a list for each temperature; the last one again where it was gone on with.
    - `result`: `"converged"`, `FLAT`, or why the solver stopped at the last temperature.
    """

    start: tuple[float, ...]
    z: tuple[float, ...]
    start_loss: float
    loss: float
    soft_loss: float
    history: tuple[tuple[float, ...], ...]
    result: str

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> "Run":
        """From plain data, as JSON gives it back."""
        history = tuple(tuple(losses) for losses in plain["history"])
        return cls(**{**plain, "start": tuple(plain["start"]), "z": tuple(plain["z"]), "history": history})

    @property
    def steps(self) -> int:
        """Steps of the solver, all temperatures together."""
        return sum(len(losses) for losses in self.history)


def begin(problem: Problem, start: Float[np.ndarray, " free"], cells: Float[np.ndarray, "count cell"]) -> Run:
    """A run that has not yet descended: the start, and the best cell that a search finds for its pixels."""
    found = search_cell(problem, start, cells)
    z = tuple(np.asarray(found.z).tolist())
    return Run(tuple(map(float, start)), z, float(found.loss_before), float(found.loss), np.inf, (), STOPPED)


def descend(
    problem: Problem,
    run: Run,
    cells: Float[np.ndarray, "count cell"],
    *,
    temperatures: Sequence[float],
    solver: Solver,
    max_steps: int,
    stop: threading.Event | None = None,
) -> Run:
    """Anneal from the best point of a run: descend, search the cell, descend at the next temperature from the best.

    **Arguments:** `cells` are tried between temperatures; `stop` ends the run early, with its best so far.
    """
    z, history, result, soft_loss = np.array(run.z), list(run.history), run.result, run.soft_loss
    best = run.loss, z
    for temperature in temperatures:
        steps = max_steps if temperature == temperatures[-1] else min(max_steps, _ON_THE_WAY)
        if stop is not None and stop.is_set():
            break
        z, losses, result = solve(problem, z, temperature, solver, steps, stop)
        history.append(tuple(losses))
        soft_loss = losses[-1]
        found = search_cell(problem, z, cells)
        z = np.asarray(found.z)
        best = min(best, (float(found.loss), z), key=lambda candidate: candidate[0])
    loss, z = best
    return Run(run.start, tuple(map(float, z)), run.start_loss, loss, soft_loss, tuple(history), result)


def solve(
    problem: Space,
    z: Float[np.ndarray, " free"],
    temperature: float,
    solver: Solver,
    max_steps: int,
    stop: threading.Event | None = None,
) -> tuple[Float[np.ndarray, " free"], list[float], str]:
    """One descent: where it ends, the loss after every step, and why it stopped.

    The solver is driven by hand, a step a call, so that it can be watched and stopped.
    """
    temperature_ = jnp.asarray(temperature, dtype=float)
    y = _unbound(solver, jnp.asarray(z))
    state, losses, result = _begin(solver, problem, temperature_, y), [], f"stopped after {max_steps} steps"
    for _ in range(max_steps):
        y, state, done, ended, loss = _step(solver, problem, temperature_, y, state)
        losses.append(float(loss))
        if done or (stop is not None and stop.is_set()):
            result = _reason(ended) if done else STOPPED
            break
        if len(losses) > _PATIENCE and losses[-1 - _PATIENCE] - loss < _FALL * loss:
            result = FLAT
            break
    return np.asarray(_bound(solver, y)), losses, result


def _reason(ended: optx.RESULTS) -> str:
    if ended == optx.RESULTS.successful:
        return "converged"
    if ended == optx.RESULTS.nonlinear_divergence:
        return "no step lowers the loss any more"
    return str(optx.RESULTS[ended])


def _fn(solver: Solver):
    return _residuals if isinstance(solver, optx.AbstractLeastSquaresSolver) else _half_squares


def _residuals(y, args):
    problem, temperature, solver = args
    return problem.residuals(_bound(solver, y), temperature), None


def _half_squares(y, args):
    residuals, _ = _residuals(y, args)
    return 0.5 * jnp.square(residuals).sum(), None


def _bound(solver: Solver, y: Float[Array, " free"]) -> Float[Array, " free"]:
    """The point in the unit box. Solvers that know no bounds walk on a line that is bent into it."""
    return y if isinstance(solver, BoundedLevenbergMarquardt) else jax.nn.sigmoid(y)


def _unbound(solver: Solver, z: Float[Array, " free"]) -> Float[Array, " free"]:
    if isinstance(solver, BoundedLevenbergMarquardt):
        return z
    z = jnp.clip(z, _EDGE, 1 - _EDGE)
    return jnp.log(z / (1 - z))


@eqx.filter_jit
def _begin(solver: Solver, problem: Space, temperature: Float[Array, ""], y: Float[Array, " free"]):
    fn, args = _fn(solver), (problem, temperature, solver)
    out, _ = eqx.filter_eval_shape(fn, y, args)
    return solver.init(fn, y, args, {}, out, None, frozenset())


@eqx.filter_jit
def _step(solver: Solver, problem: Space, temperature: Float[Array, ""], y: Float[Array, " free"], state):
    fn, args = _fn(solver), (problem, temperature, solver)
    y, state, _ = solver.step(fn, y, args, {}, state, frozenset())
    done, result = solver.terminate(fn, y, args, {}, state, frozenset())
    loss = state.f_info.as_min() if hasattr(state, "f_info") else fn(y, args)[0]
    return y, state, done, result, loss
