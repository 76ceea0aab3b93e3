"""One descent in the unit box, driven step by step so that it can be watched and stopped."""

import threading
from typing import Annotated, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Float
from typing_extensions import TypeAliasType

from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._types import strong
from lgmd2jax.fitting._search.space import Space
from lgmd2jax.fitting._solver.levenberg_marquardt import BoundedLevenbergMarquardt

Solver = TypeAliasType(
    "Solver",
    Annotated[
        optx.AbstractLeastSquaresSolver | optx.AbstractMinimiser,
        "one of optimistix', such as optimistix.BFGS(1e-8, 1e-8)",
    ],
)
# Near the hard end the loss is a fine staircase, on which no gradient vanishes: enough when it hardly falls.
_PATIENCE, _FALL = 20, 1e-3
CONVERGED = "converged"
FLAT = f"flat: the loss fell by less than {_FALL:.1%} in {_PATIENCE} steps"
STOPPED = "stopped by hand"
FINAL = (CONVERGED, FLAT)  # results after which more steps change nothing
_EDGE = 1e-3  # a solver without bounds starts at least so far from them, in the unit box


class Descent(NamedTuple):
    """Where a descent ended in the unit box, the loss after every step, and why it stopped."""

    z: Float[np.ndarray, " free"]
    losses: list[float]
    result: str


def descend(
    space: Space,
    z: Float[np.ndarray, " free"],
    temperature: float,
    solver: Solver,
    max_steps: int,
    stop: threading.Event | None = None,
) -> Descent:
    """Descend from `z` at one temperature; `stop` ends it after the next step."""
    temperature_ = strong(temperature)
    y = _from_box(solver, jax.device_put(z))
    state, losses, result = _begin(solver, space, temperature_, y), [], f"stopped after {max_steps} steps"
    for _ in range(max_steps):
        y, state, done, code, loss = _step(solver, space, temperature_, y, state)
        losses.append(float(loss))
        if done or (stop is not None and stop.is_set()):
            result = _reason(code) if done else STOPPED
            break
        if len(losses) > _PATIENCE and losses[-1 - _PATIENCE] - losses[-1] < _FALL * losses[-1]:
            result = FLAT
            break
    return Descent(np.asarray(_to_box(solver, y)), losses, result)


def _reason(code: optx.RESULTS) -> str:
    if code == optx.RESULTS.successful:
        return CONVERGED
    if code == optx.RESULTS.nonlinear_divergence:
        return "no step lowers the loss any more"
    return str(optx.RESULTS[code])


def _objective(solver: Solver):
    return _residuals if isinstance(solver, optx.AbstractLeastSquaresSolver) else _half_squares


def _residuals(y, args):
    space, temperature, solver = args
    return space.residuals(_to_box(solver, y), temperature), None


def _half_squares(y, args):
    residuals, _ = _residuals(y, args)
    return 0.5 * jnp.square(residuals).sum(), None


def _to_box(solver: Solver, y: Float[Array, " free"]) -> Float[Array, " free"]:
    """The point in the unit box. A solver that knows no bounds works on the logits of the point."""
    return y if isinstance(solver, BoundedLevenbergMarquardt) else jax.nn.sigmoid(y)


def _from_box(solver: Solver, z: Float[Array, " free"]) -> Float[Array, " free"]:
    if isinstance(solver, BoundedLevenbergMarquardt):
        return z
    z = jnp.clip(z, _EDGE, 1 - _EDGE)
    return jnp.log(z / (1 - z))


@traced_once
def _begin(solver: Solver, space: Space, temperature: Float[Array, ""], y: Float[Array, " free"]):
    objective, args = _objective(solver), (space, temperature, solver)
    out, _ = eqx.filter_eval_shape(objective, y, args)
    return solver.init(objective, y, args, {}, out, None, frozenset())


@traced_once
def _step(solver: Solver, space: Space, temperature: Float[Array, ""], y: Float[Array, " free"], state):
    objective, args = _objective(solver), (space, temperature, solver)
    y, state, _ = solver.step(objective, y, args, {}, state, frozenset())
    done, code = solver.terminate(objective, y, args, {}, state, frozenset())
    # Our own solver knows the loss; of others no interface tells it.
    loss = solver.loss(state) if isinstance(solver, BoundedLevenbergMarquardt) else _half_squares(y, args)[0]
    return y, state, done, code, loss
