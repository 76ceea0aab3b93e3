"""The most telling stimulus: the one that a neuron answers most, and the one that tells two circuits apart best."""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import scipy
from jaxtyping import Array, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._channels import Channel
from lgmd2jax._eye import Eye
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.thresholds import Hard, Soft
from lgmd2jax._network.variants import at_eye
from lgmd2jax._protocol.condition import Condition
from lgmd2jax._targets.observation import Observation
from lgmd2jax._types import Key, check_key
from lgmd2jax._words import nearest
from lgmd2jax.fitting._bounds import Linear, Log, Scale, between, check_bounds
from lgmd2jax.fitting._result import Fit
from lgmd2jax.fitting._search.points import seed_of, sobol
from lgmd2jax.stimuli import FAMILIES, Stimulus
from lgmd2jax.stimuli._family import outline

Measure = Literal["total", "peak"]
Neuron = Fit | AbstractNetwork

_TEMPERATURE = 0.5  # of the thresholds through which gradients pass
_STEPS = 25  # of an ascent, at most
_CANDIDATES = 8  # points for each start: the best of them are ascended from


@dataclasses.dataclass(frozen=True)
class TellingStimulus:
    """A stimulus that was searched for, and how much it tells.

    - `stimulus`: with whole grey levels, as a display shows it. `arguments`: of its family, those that were varied.
    - `score`: of the hard models on these frames: of `strongest_stimulus` the response, of `discriminating_stimulus`
      the distance of the two responses in standard errors.
    - `scores`: of all starts, before and after their ascent.
    - `measured`: gives the same score of any other stimulus, such as those of a protocol.
    """

    stimulus: Stimulus
    arguments: dict[str, float]
    score: float
    scores: Float[np.ndarray, "start 2"]
    measured: Callable[[Stimulus | Condition], float] = dataclasses.field(repr=False)


@checked
def strongest_stimulus(
    neuron: Neuron,
    family: str,
    vary: Mapping[str, tuple[float | int, float | int] | Linear | Log],
    *,
    key: Key,
    eye: Eye | None = None,
    measure: Measure = "total",
    starts: int = 4,
    **fixed: Any,
) -> TellingStimulus:
    """The stimulus of a family that a neuron answers most, by gradient ascent on the family's arguments.

    The ascent follows the gradient through stimulus and soft model, in the box of the arguments, from several points.
    What counts is the hard model on whole grey levels: the starts are the best of eight times as many points by that
    measure, and of all starts and ends the best is taken.

    ```python
    found = lgmd.strongest_stimulus(
        fit, "looming", {"l_over_v": lgmd.Log(5, 80), "stop_angle": (20, 120)}, key=key, start_ms=-1000, end_ms=300
    )
    ```

    **Arguments:**

    - `neuron`: a fit, or a model with an eye.
    - `family`: a name of `lgmd.stimuli.FAMILIES`. `vary`: its arguments with their ranges. `fixed`: other arguments,
      `start_ms` and `end_ms` among them.
    - `key`: of the starts' random points; `starts`: how many there are.
    - `eye`: what it is rendered for, by default the model's own; at the frame rate of a display the model is taken to
      that rate (`at_eye`).
    - `measure`: `"total"`, the integral of U' above rest in ms, or `"peak"`.

    **Raises:** `ValueError` for what the family does not take, ranges that are empty, and a model without an eye.
    """
    if measure not in ("total", "peak"):
        raise ValueError(f"measure is {measure!r}; choose 'total' or 'peak'")
    model = _model(neuron, eye, "neuron")

    def score(thresholds, frames, time):
        above = dataclasses.replace(model, thresholds=thresholds)(frames).smp_adapted - 0.5
        return jnp.sum(above) * (time[1] - time[0]) if measure == "total" else jnp.max(above)

    return _search(model, score, family, vary, fixed, key, starts)


@checked
def discriminating_stimulus(
    one: Neuron,
    other: Neuron,
    family: str,
    vary: Mapping[str, tuple[float | int, float | int] | Linear | Log],
    *,
    key: Key,
    eye: Eye | None = None,
    channel: Channel | None = None,
    noise: float | int | None = None,
    starts: int = 4,
    **fixed: Any,
) -> TellingStimulus:
    """The stimulus of a family whose responses tell two circuits apart best, under the noise of the recording.

    Its score is the distance sqrt(sum over frames of ((a - b)/noise)^2), the d' of an observer who knows both.

    **Arguments:** as of `strongest_stimulus`, and

    - `one`, `other`: two fits, or models with an eye.
    - `channel`: that would be recorded; by default the first that both fits had targets in, else `"smp_adapted"`.
    - `noise`: standard deviation of a frame, in the unit of the channel, were its neighbours no copies of it; by
      default that of the fits' targets, the larger of the two.

    **Raises:** `ValueError` as `strongest_stimulus`, and for a noise that neither is given nor follows from a fit.
    """
    eye = eye or _model(one, None, "one").eye
    models = [_model(neuron, eye, name) for neuron, name in ((one, "one"), (other, "other"))]
    fits = [neuron for neuron in (one, other) if isinstance(neuron, Fit)]
    recorded = _common_channel(fits) if channel is None else channel
    known = [fit.errors[recorded] for fit in fits if math.isfinite(fit.errors.get(recorded, math.nan))]
    if noise is None and not known:
        raise ValueError(
            f"noise is not given, and no fit had targets in {recorded!r} that tell it; give its standard error"
        )
    error = float(max(known) if noise is None else noise)
    if not (math.isfinite(error) and error > 0):
        raise ValueError(f"noise is {error}; give a positive number")
    observations = [neuron.observation if isinstance(neuron, Fit) else Observation() for neuron in (one, other)]

    def score(thresholds, frames, time):
        curves = []
        for model, observation in zip(models, observations, strict=True):
            response = dataclasses.replace(model, thresholds=thresholds)(frames)
            is_rate = recorded == "rate"
            curves.append(observation(response.smp_adapted, time) if is_rate else getattr(response, recorded))
        return jnp.sqrt(jnp.square((curves[0] - curves[1]) / error).sum() + 1e-12)

    return _search(models[0], score, family, vary, fixed, key, starts)


def _common_channel(fits: Sequence[Fit]) -> Channel:
    """The first that all fits had targets in; of plain models the potential."""
    common: list[Channel] = (
        [name for name in fits[0].channels if all(name in fit.channels for fit in fits)] if fits else []
    )
    return common[0] if common else "smp_adapted"


def _model(neuron: Neuron, eye: Eye | None, name: str) -> AbstractNetwork:
    model = neuron.model if isinstance(neuron, Fit) else neuron
    if model.eye is None:
        raise ValueError(
            f"{name} has no eye, for which a stimulus could be rendered; give it one: LGMD2(..., eye=Eye())"
        )
    return model if eye is None else at_eye(model, eye)


def _search(
    model: AbstractNetwork,
    score: Callable[..., Float[Array, ""]],
    family: str,
    vary: Mapping[str, Any],
    fixed: Mapping[str, Any],
    key: Key,
    starts: int,
) -> TellingStimulus:
    check_key(key)
    if family not in FAMILIES:
        raise ValueError(f"family is {family!r}; choose {nearest(family, FAMILIES)}")
    if not vary:
        raise ValueError("vary is empty; give at least one argument of the family with its range")
    for name in ("start_ms", "end_ms"):
        if name not in fixed:
            raise ValueError(f"{name} is missing; give the window in which all stimuli are shown")
    ranges = {name: _range(name, choice) for name, choice in vary.items()}
    eye: Any = model.eye
    renderer = FAMILIES[family]
    names, soft = tuple(ranges), Soft(_TEMPERATURE)

    def arguments(z):
        return {name: ranges[name](z[i]) for i, name in enumerate(names)}

    def render(z) -> Stimulus:
        return renderer(eye, **fixed, **arguments(z))

    outline(renderer, eye, **fixed, **arguments(np.full(len(names), 0.5)))  # refuses what the family does not take

    @eqx.filter_jit
    def ascended(z):
        def both(z):
            stimulus = render(z)
            value = score(soft, stimulus.frames, stimulus.time)
            return value, value

        slope, value = jax.jacfwd(both, has_aux=True)(z)
        return value, slope

    @eqx.filter_jit
    def hard(frames, time):
        return score(Hard(), frames, time)

    def judged(stimulus: Stimulus) -> float:
        return float(hard(jnp.asarray(stimulus.frames, float), jnp.asarray(stimulus.time)))

    def downhill(z):
        value, slope = ascended(jnp.asarray(z))
        return -float(value), -np.asarray(slope, dtype=float)

    candidates = sobol(len(names), _CANDIDATES * starts, seed_of(key))
    told = [judged(_whole(render(jnp.asarray(z)))) for z in candidates]
    points, ends = candidates[np.argsort(told)[::-1][:starts]], []
    for point in points:
        bounds = [(0.0, 1.0)] * len(names)
        found = scipy.optimize.minimize(
            downhill, point, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": _STEPS}
        )
        ends.append(np.clip(found.x, 0, 1))
    shown = [[_whole(render(jnp.asarray(z))) for z in pair] for pair in zip(points, ends, strict=True)]
    scores = np.array([[judged(stimulus) for stimulus in pair] for pair in shown])
    best = np.unravel_index(np.argmax(scores), scores.shape)
    z = (points, ends)[best[1]][best[0]]

    def measured(stimulus: Stimulus | Condition) -> float:
        return judged(stimulus.render() if isinstance(stimulus, Condition) else stimulus)

    values = {name: float(value) for name, value in arguments(z).items()}
    return TellingStimulus(shown[best[0]][best[1]], values, float(scores[best]), scores, measured)


def _range(name: str, choice: Any) -> Callable[[Any], Any]:
    """From z in [0, 1] to an argument."""
    low, high = (choice.low, choice.high) if isinstance(choice, (Linear, Log)) else choice
    if low is None or high is None:
        raise ValueError(f"{name} has no bounds; give both: the low and the high one")
    scale: Scale = "log" if isinstance(choice, Log) else "linear"
    check_bounds(name, low, high, scale)
    return lambda z: between(low, high, scale, z)


def _whole(stimulus: Stimulus) -> Stimulus:
    """In the 256 grey levels of a display."""
    return dataclasses.replace(stimulus, frames=jnp.clip(jnp.rint(stimulus.frames), 0, 255))
