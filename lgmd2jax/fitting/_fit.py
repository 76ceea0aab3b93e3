"""Least squares from recorded curves to parameters, annealed from soft thresholds towards hard ones."""

from collections.abc import Sequence

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Float

from lgmd2jax._model import LGMD2
from lgmd2jax._parameters import Parameters
from lgmd2jax._thresholds import Hard, Soft, Thresholds
from lgmd2jax.fitting._free import Free
from lgmd2jax.fitting._observation import Observation
from lgmd2jax.fitting._target import Target
from lgmd2jax.stimuli import Stimulus

TEMPERATURES = (1.0, 0.3, 0.1)


class Fit(eqx.Module):
    """What a fit found.

    - `model`: the fitted model with hard thresholds, to be handed over.
    - `soft`: the same parameters at the last temperature.
    - `observation`: from the potential to the rate.
    - `loss`: half the weighted sum of squares of the hard model.
    - `result`: why the solver stopped, at the last temperature.
    - `steps`: steps of the solver at each temperature.
    """

    model: LGMD2
    soft: LGMD2
    observation: Observation
    loss: float
    result: str
    steps: tuple[int, ...]


def fit(
    model: LGMD2,
    conditions: Sequence[tuple[Stimulus, Target]],
    observation: Observation,
    free: Free,
    temperatures: Sequence[float] = TEMPERATURES,
) -> Fit:
    """Fit the free parameters by Levenberg-Marquardt, each temperature from the one before.

    **Arguments:** `model` holds what is fixed; `conditions` pair a stimulus with its target. Use float64.

    **Raises:** `ValueError` for no conditions, or for more free parameters than frames with a weight.
    """
    frames = sum(int(target.weight.sum()) for _, target in conditions)
    if frames < len(free.bounds):
        raise ValueError(f"{len(free.bounds)} parameters are free, but only {frames} frames have a target; add data")

    def residuals(raw, temperature):
        soft = with_thresholds(model, free.insert(model.parameters, raw), Soft(temperature))
        return [_difference(soft, observation, *condition) for condition in conditions]

    solver = optx.LevenbergMarquardt(rtol=1e-8, atol=1e-8)
    raw, steps, result = jnp.zeros(len(free.bounds)), [], optx.RESULTS.successful
    for temperature in temperatures:
        solution = optx.least_squares(residuals, solver, raw, jnp.asarray(temperature), throw=False, max_steps=200)
        raw, result = solution.value, solution.result
        steps.append(int(solution.stats["num_steps"]))
    parameters = free.insert(model.parameters, raw)
    fitted = with_thresholds(model, parameters, Hard())
    soft = with_thresholds(model, parameters, Soft(temperatures[-1]))
    loss = 0.5 * sum(float(jnp.sum(_difference(fitted, observation, *condition) ** 2)) for condition in conditions)
    status = "converged" if result == optx.RESULTS.successful else optx.RESULTS[result]
    return Fit(fitted, soft, observation, loss, status, tuple(steps))


def with_thresholds(model: LGMD2, parameters: Parameters, thresholds: Thresholds) -> LGMD2:
    """The same structure with other parameters and thresholds."""
    return LGMD2(parameters, thresholds, model.n_p, model.low_pass, model.N_ts, model.eye)


def _difference(model: LGMD2, observation: Observation, stimulus: Stimulus, target: Target) -> Array:
    rate = observation(model(stimulus.frames, stimulus.fps).smp_adapted, stimulus.time)
    return jnp.asarray(target.weight) * (rate - target.values)


def variance_explained(rate: Float[np.ndarray, " time"], target: Target) -> float:
    """R2 over the frames with a weight."""
    mean = np.average(target.values, weights=target.weight)
    rest = np.average((target.values - rate) ** 2, weights=target.weight)
    return float(1 - rest / np.average((target.values - mean) ** 2, weights=target.weight))
