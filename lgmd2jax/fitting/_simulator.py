"""A model and its stimuli as a function from parameters to summaries, as simulation-based inference wants it."""

import math
from collections.abc import Callable, Sequence
from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from typing_extensions import TypeAliasType

from lgmd2jax._arguments.checked import checked
from lgmd2jax._channels import Channel
from lgmd2jax._compute.batching import each
from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._protocol.condition import Condition
from lgmd2jax._signals import vertex
from lgmd2jax._targets.observation import Observation
from lgmd2jax._targets.target import Target
from lgmd2jax._types import Key, check_key
from lgmd2jax.fitting._free import Free
from lgmd2jax.fitting._problem import Problem, problem_of
from lgmd2jax.stimuli import Stimulus

# From the times in ms and the response to a stimulus to the numbers that sum it up.
Summary = TypeAliasType("Summary", Callable[[Float[Array, " time"], Float[Array, " time"]], Float[Array, " summary"]])
Batch = Float[Array | np.ndarray, "*batch parameter"]


def features(time: Float[Array, " time"], response: Float[Array, " time"]) -> Float[Array, " 3"]:
    """Mean and peak of a response, and the time of the peak in ms, by the parabola through it and its neighbours."""
    top = jnp.clip(jnp.argmax(response), 1, len(time) - 2)
    place = vertex(response[top - 1], response[top], response[top + 1])
    return jnp.stack([response.mean(), response.max(), time[top] + place * (time[1] - time[0])])


def curves(time: Float[Array, " time"], response: Float[Array, " time"]) -> Float[Array, " time"]:
    """The response itself."""
    return response


_KERNEL_MS = 20.0  # of the smoothing of counts, as is usual for rates of LGMD and DCMD
SUMMARIES: dict[str, Summary] = {"features": features, "curves": curves}


class Simulator(eqx.Module):
    """Parameters in, summaries of the responses to all stimuli out; `as_simulator` makes one.

    ```python
    simulator = lgmd.as_simulator(model, conditions, free)
    theta = simulator.prior(jax.random.key(0), 1000)         # (1000, parameter), within the bounds
    x = simulator(theta)                                     # (1000, summary); without noise
    x = simulator(theta, jax.random.key(1))                  # with that of the recording
    ```

    A NumPy array, or a tensor of another library, gives a NumPy array; an array of JAX, also a traced one, one of JAX,
    so that it jits, vmaps and differentiates.

    - `names`, `units`: of the parameters. `low`, `high`: their bounds, for a prior that is uniform between them.
    """

    problem: Problem
    times: tuple[Float[Array | np.ndarray, " _"], ...]
    summary: Summary = eqx.field(static=True)
    trials: int | None = eqx.field(static=True)
    noise: float | int | None = eqx.field(static=True)

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters, in their order along the last axis of `theta`."""
        return self.problem.free.names

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each parameter, "1" for a plain number."""
        return tuple(parameter.symbol.unit for parameter in self.problem.free.parameters)

    @property
    def low(self) -> Float[np.ndarray, " parameter"]:
        """The lower bound of each parameter."""
        return np.array([parameter.low for parameter in self.problem.free.parameters])

    @property
    def high(self) -> Float[np.ndarray, " parameter"]:
        """The upper bound of each parameter."""
        return np.array([parameter.high for parameter in self.problem.free.parameters])

    @checked
    def prior(self, key: Key, count: int) -> Float[Array, "count parameter"]:
        """Random parameters within the bounds; of those whose factors count, every factor is as likely."""
        check_key(key)
        z = jax.random.uniform(key, (count, len(self.names)))
        return jnp.stack([parameter.value(z[:, i]) for i, parameter in enumerate(self.problem.free.parameters)], axis=1)

    @checked
    def __call__(self, theta: Any, key: Key | None = None) -> Any:
        """The summaries, (batch, summary) for parameters (batch, parameter), or (summary,) for (parameter,).

        **Arguments:** `theta`: in the parameters' own units, in the order of `names`. `key`: of the noise; without one
        there is none.

        **Raises:** `ValueError` for another number of parameters, and for a key where no noise was asked for.
        """
        is_jax = isinstance(theta, jax.Array)
        points = theta if is_jax else np.asarray(theta, dtype=float)
        if points.ndim not in (1, 2) or points.shape[-1] != len(self.names):
            raise ValueError(
                f"theta has shape {points.shape}; give (batch, {len(self.names)}): {', '.join(self.names)}"
            )
        if key is not None and self.trials is None and self.noise is None:
            raise ValueError("key is given, but the simulator has no noise; give as_simulator trials or noise")
        rows = jnp.asarray(points).reshape(-1, len(self.names))
        keys = None if key is None else jax.random.split(key, len(rows))
        answers = _simulate(self, rows, keys).reshape(*points.shape[:-1], -1)
        return answers if is_jax else np.asarray(answers)


@checked
def as_simulator(
    model: AbstractNetwork,
    conditions: Sequence[Condition | Stimulus | tuple[Stimulus, Any]],
    free: Free,
    *,
    summaries: Literal["features", "curves"] | Summary = "features",
    channel: Channel = "rate",
    observation: Observation | None = None,
    trials: int | None = None,
    noise: float | int | None = None,
) -> Simulator:
    """A model and stimuli as a simulator, for tools of simulation-based inference such as sbi, BayesFlow or numpyro.

    **Arguments:**

    - `model`, `free`, `observation`: as for `fit`. Thresholds are the model's: soft ones where gradients are wanted.
    - `conditions`: what is shown. Their targets do not matter.
    - `summaries`: `"features"`, for each stimulus mean, peak and time of the peak in ms; `"curves"`, all frames; or a
      function from the times in ms and the response to an array of one axis. Those of all stimuli follow each other.
    - `channel`: that is summed up.
    - `trials`: how many trials a rate is the average of: it is smoothed by a Gaussian of 20 ms, and with noise the
      spikes of each frame are those of a Poisson process. Under noise a peak is higher than without, a mean is not.
    - `noise`: or the standard deviation of normal noise on each frame, in the unit of the channel.

    **Raises:** `ValueError` for no stimuli, both kinds of noise, trials of another channel than the rate, and as `fit`.
    """
    if trials is not None and (noise is not None or channel != "rate" or trials < 1):
        raise ValueError("trials is for the channel 'rate', 1 or more, without other noise; give one kind of noise")
    if noise is not None and not (math.isfinite(noise) and noise > 0):
        raise ValueError(f"noise is {noise}; give a positive number")
    if not conditions:
        raise ValueError("conditions is empty; give at least one stimulus")
    stimuli = [_stimulus(condition) for condition in conditions]
    pairs = [(stimulus, [Target(channel, np.zeros(len(stimulus.time))).on(stimulus)]) for stimulus in stimuli]
    free = free.of(type(model.parameters))
    free.check_used_by(model)
    problem = problem_of(model, observation or Observation(), free, pairs, "squares")
    times = tuple(np.asarray(stimulus.time, dtype=float) for stimulus in stimuli)
    summary = SUMMARIES[summaries] if isinstance(summaries, str) else summaries
    return Simulator(problem, times, summary, trials, noise)


def _stimulus(condition: Condition | Stimulus | tuple[Stimulus, Any]) -> Stimulus:
    if isinstance(condition, Condition):
        return condition.render()
    return condition if isinstance(condition, Stimulus) else condition[0]


@traced_once
def _simulate(
    simulator: Simulator, theta: Float[Array, "batch parameter"], keys: Array | None
) -> Float[Array, "batch summary"]:
    if keys is None:
        return each(lambda point: _answer(simulator, point, None), theta)
    return each(lambda pair: _answer(simulator, *pair), (theta, keys))


def _answer(simulator: Simulator, theta: Float[Array, " parameter"], key: Key | None) -> Float[Array, " summary"]:
    problem = simulator.problem
    z = jnp.stack([parameter.place(theta[i]) for i, parameter in enumerate(problem.free.parameters)])
    model, observation = problem.at(z)
    predicted = problem.curves(model, observation, problem.sums(model))
    answers = []
    for number, (time, ((batch, slot, row),)) in enumerate(zip(simulator.times, problem.places, strict=True)):
        response = predicted[batch][slot][row][: len(time)]
        own = None if key is None else jax.random.fold_in(key, number)
        response = _recorded(simulator, jnp.asarray(time), response, own)
        answers.append(simulator.summary(jnp.asarray(time), response))
    return jnp.concatenate(answers)


def _recorded(
    simulator: Simulator, time: Float[Array, " time"], response: Float[Array, " time"], key: Key | None
) -> Float[Array, " time"]:
    """What would be recorded: of trials the rate behind the kernel, with noise where there is a key."""
    if simulator.trials is None:
        if key is None or simulator.noise is None:
            return response
        return response + simulator.noise * jax.random.normal(key, response.shape)
    if key is not None:
        exposure = simulator.trials * (time[1] - time[0]) / 1000
        response = jax.random.poisson(key, jnp.maximum(response, 0) * exposure).astype(response.dtype) / exposure
    kernel = jax.nn.softmax(-0.5 * jnp.square((time[:, None] - time[None, :]) / _KERNEL_MS), axis=1)
    return kernel @ response
