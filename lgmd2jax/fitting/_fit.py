"""The fit: screening on two levels, descents from the best, the choice by the model's own loss, the uncertainty."""

import dataclasses
import hashlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import jax
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._compute.fingerprint import fingerprint
from lgmd2jax._compute.finished_work import Memory
from lgmd2jax._compute.tasks import Result, Work
from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.noise import inhibition_in_noise
from lgmd2jax._network.thresholds import Hard, Soft, StraightThrough
from lgmd2jax._targets.observation import Observation, observation_symbols
from lgmd2jax._types import check_key, strong
from lgmd2jax.fitting._choice import chosen_candidate
from lgmd2jax.fitting._conditions import AnyCondition, Rendered, render
from lgmd2jax.fitting._curve import Curve, curve_of, rest_of
from lgmd2jax.fitting._free import Free
from lgmd2jax.fitting._problem import Curves, Problem, chi2_residuals, problem_of
from lgmd2jax.fitting._result import Fit
from lgmd2jax.fitting._robust import Loss
from lgmd2jax.fitting._run import Run
from lgmd2jax.fitting._search.descent import FINAL, STOPPED, Solver
from lgmd2jax.fitting._search.search import TEMPERATURES, Search, check_counts
from lgmd2jax.fitting._starts import CurveStarts
from lgmd2jax.fitting._uncertainty.covariance import Uncertainty, linearised_uncertainty, prediction_band
from lgmd2jax.fitting._uncertainty.jacobian import Sensitivity, known_rows, sensitivity_at
from lgmd2jax.fitting._uncertainty.linearity import nonlinear_parameters
from lgmd2jax.fitting._uncertainty.profile import profiled_intervals
from lgmd2jax.stimuli import Stimulus

if TYPE_CHECKING:
    from distributed import Client

_LOUD = 0.5  # of the inhibiting FFI; noise that reaches it takes part of the response away
_APART = 0.02  # in the unit box; starts closer to a better one are not descended


@checked
def fit(
    model: AbstractNetwork,
    conditions: Sequence[AnyCondition],
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
    choose: Callable[[AbstractNetwork], float] | None = None,
) -> Fit:
    """Fit a model's free parameters to target curves; `fit_each` does so for each animal by itself.

    ```python
    jax.config.update("jax_enable_x64", True)
    eye = lgmd.Eye.preset("locust")
    looms = [lgmd.stimuli.looming(eye, l_over_v=ms, start_ms=-1000, end_ms=300) for ms in (20.0, 40.0)]
    twin = lgmd.LGMD2(lgmd.Parameters(k=0.5, tau3=300.0), eye=eye)
    pairs = [(loom, lgmd.ModelTarget(model=twin)) for loom in looms]    # in its place, a `Target` with your recording
    fit = lgmd.fit(lgmd.LGMD2(eye=eye), pairs, lgmd.Free(k=None, tau3=(100, 1000)), key=jax.random.key(0))
    print(fit)                                      # the report: values, intervals, and what to mistrust
    ```

    Random points within the bounds are screened, and the best are descended. A model with hard thresholds is descended
    on soft ones whose temperature falls, and the best *hard* candidate is the result; one with soft thresholds is
    descended at its own temperature.

    **Arguments:**

    - `model`: what stays fixed, and the values from which the search sets out.
    - `conditions`: those of a protocol, or pairs of a stimulus with its target or targets.
    - `free`: which parameters may change, within which bounds.
    - `key`: of the search's random points. The same key gives the same fit.
    - `observation`: how a `rate` arises from the potential.
    - `temperatures`: of the descent, falling; by default .5, .2, .05, or that of a soft model.
    - `pixel_points`: how many points of the parameters of the pixels are screened. `cell_points`: with each of them,
      how many points of those of the cell, which cost little.
    - `descend`: how many of the best points are descended.
    - `loss`: `"squares"`, or `"huber"`, `"soft_l1"`, `"cauchy"`, which outliers cannot pull far.
    - `solver`: any optimistix least-squares solver or minimiser; by default the bounded Levenberg-Marquardt.
    - `max_steps`: of the solver at the last temperature; at those before, 20 suffice. The best descent gets five times
      as many to converge.
    - `absolute_errors`: whether the targets' errors are believed as they are; by default where all targets have them.
      Otherwise they are weights, and the residual variance sets the scale of all uncertainty.
    - `throw`: whether to raise `RuntimeError` where the result is not `"converged"`.
    - `progress`: show a bar with the best loss so far.
    - `memory`: a mapping, such as a dict, that keeps finished work; given again, the fit goes on from there. That of
      another fit is refused.
    - `client`: of a Dask cluster, on whose workers the starts are spread instead of on the cores here.
    - `choose`: a function of a model that returns a score, higher for a better one: what else the model must do. Of the
      start, the ends of the descents and points between, the model with the highest score is the result, of equals the
      one with the least loss. Without it the least loss decides.

    On Ctrl-C the best so far is returned; its `result` says so. Before the first start is finished the
    `KeyboardInterrupt` goes on to the caller. Fits want float64: `jax_enable_x64`.

    **Raises:** `ValueError` for conditions without targets, for a start outside of its bounds, for more free parameters
    than independent samples, for a prior beside targets without errors, for the memory of another fit, and for settings
    that make no sense.
    """
    check_key(key)
    pairs, observation, free = render(conditions), observation or Observation(), free.of(type(model.parameters))
    free.check_used_by(model)
    temperatures = _temperatures(model, temperatures)
    counts = {"pixel_points": pixel_points, "cell_points": cell_points, "descend": descend, "max_steps": max_steps}
    _check(pairs, free, counts)
    problem = problem_of(model, observation, free, pairs, loss)
    samples = problem.samples()
    if samples < len(free):
        raise ValueError(
            f"{len(free)} parameters are free, but the targets hold only {samples:.3g} independent samples; "
            "fix some, or add data"
        )
    start = free.place(model.parameters, observation)
    search = Search.of(
        problem,
        problem.cell_indices,
        start,
        key=key,
        pixel_points=pixel_points,
        cell_points=cell_points,
        temperatures=temperatures,
        solver=solver,
    )
    starts = CurveStarts(search, max_steps)
    digest, total = "" if memory is None else fingerprint(starts), pixel_points + descend + 1
    with Work({} if memory is None else memory, progress, client, digest=digest, total=total) as work:
        screened = work.do("screening", starts.screen, range(pixel_points), starts.compile_screening)
        chosen = _apart(screened, descend)
        if not chosen:
            raise ValueError("no point of the search gave a finite loss; narrow the bounds of free, or fix its targets")
        descended = work.do("descending", partial(starts.descend, screened), chosen, search.compile_descent)
        best = min(descended, key=lambda number: descended[number]["loss"], default=None)
        if best is not None and descended[best]["result"] not in FINAL:
            descended |= work.do("finishing", partial(starts.finish, descended), [best])
        stopped = work.stop.is_set()
    runs = sorted((Run.of(plain) for plain in descended.values()), key=lambda run: run.loss)
    runs = runs or [_not_run(screened[chosen[0]])]
    result = STOPPED if stopped else runs[0].result
    if throw and result not in FINAL:
        raise RuntimeError(f"the fit did not converge: {result}; see fit(..., throw=False)")

    # All that is known of the best point: its curves, and how well they determine it.
    z, value, choice = np.array(runs[0].z), runs[0].loss, {}
    if choose is not None and not stopped:
        z, value, choice = chosen_candidate(problem, start, runs, choose)
        if not np.array_equal(z, runs[0].z):
            result = "chosen by its score"
    slopes = sensitivity_at(problem, jax.device_put(z), strong(temperatures[-1]))
    if absolute_errors is None:
        absolute_errors = all(target.has_error for _, targets in pairs for target in targets)
    u = _uncertainty(problem, z, slopes, absolute_errors)
    residuals, nonlinear = chi2_residuals(problem, temperatures[-1], u.variance), ()
    if problem.has_counts:
        u = dataclasses.replace(u, intervals=profiled_intervals(residuals, z, u, free.unpacked))
    else:
        nonlinear = nonlinear_parameters(residuals, z, u)
    model, observation = problem.at(z)
    return Fit(
        model=model,
        observation=observation,
        free=free,
        z=z,
        start={
            parameter.name: float(parameter.value(at)) for parameter, at in zip(free.parameters, start, strict=True)
        },
        loss=value,
        soft_loss=0.5 * float(np.square(slopes.residuals).sum()),
        temperatures=temperatures,
        uncertainty=u,
        nonlinear=nonlinear,
        curves=_curves(problem, observation, pairs, slopes, _hard_curves(problem, jax.device_put(z)), u),
        runs=tuple(runs),
        screened=tuple(sorted(point["loss"] for point in screened.values())),
        errors=problem.frame_errors(u.variance),
        result=result,
        stats={
            "pixel_points": pixel_points,
            "cell_points": cell_points,
            "loss": loss,
            "seed": list(search.seed),
            "data": int(problem.known().sum()) - problem.priors,
            "num_steps": sum(run.steps for run in runs),
            **choice,
            **_loudest(model, pairs),
            "rules": _rules(pairs),
            "stimuli": {stimulus.name: digest_of(stimulus) for stimulus, _ in pairs},
        },
        problem=problem,
    )


def _temperatures(model: AbstractNetwork, temperatures) -> tuple[float, ...]:
    if temperatures is None:
        own = model.thresholds
        temperatures = [own.temperature] if isinstance(own, Soft | StraightThrough) else TEMPERATURES
    try:
        temperatures = tuple(float(temperature) for temperature in temperatures)
    except (TypeError, ValueError):
        raise ValueError(f"temperatures is {temperatures!r:.60}; give a list of positive numbers") from None
    if not temperatures or not all(np.isfinite(temperature) and temperature > 0 for temperature in temperatures):
        raise ValueError(f"temperatures is {temperatures}; give one or more positive numbers")
    if any(after >= before for before, after in pairwise(temperatures)):
        raise ValueError(f"temperatures is {temperatures}; give falling numbers")
    return temperatures


def _check(pairs: Sequence[Rendered], free: Free, counts: dict[str, int]) -> None:
    check_counts(counts, at_least=1)
    targets = [target for _, targets in pairs for target in targets]
    of_rate = [name for name in free.names if name in observation_symbols()]
    if of_rate and not any(target.channel == "rate" for target in targets):
        raise ValueError(f"{of_rate[0]} is free, but no target is a rate, which alone depends on it; fix it")
    with_prior = [parameter.name for parameter in free.parameters if parameter.prior]
    if with_prior and not all(target.has_error for target in targets):
        raise ValueError(
            f"{with_prior[0]} has a prior, which can only be weighed against data of known error; give targets an error"
        )


def _apart(screened: Mapping[int, Result], count: int) -> list[int]:
    """The best points that are not near a better one."""
    chosen: list[int] = []
    for number in sorted(screened, key=lambda i: screened[i]["loss"]):
        z = np.array(screened[number]["z"])
        if all(np.abs(z - screened[other]["z"]).max() > _APART for other in chosen):
            chosen.append(number)
        if len(chosen) == count:
            break
    return chosen


def _not_run(point: Result) -> Run:
    z, loss = tuple(point["z"]), point["loss"]
    return Run(z, z, loss, loss, float("inf"), (), STOPPED)


def _loudest(model: AbstractNetwork, pairs: Sequence[Rendered]) -> dict[str, Any]:
    """Of the conditions filmed with noise the one in which noise alone inhibits most, where that is much."""
    noises = {(float(each.parameters["noise"]), each.fps) for each, _ in pairs if "noise" in each.parameters}
    model = dataclasses.replace(model, thresholds=Hard(), eye=None)
    shares = {(noise, fps): inhibition_in_noise(model, noise, fps) for noise, fps in noises}
    loudest = max(shares, key=lambda pair: shares[pair], default=None)
    if loudest is None or shares[loudest] < _LOUD:
        return {}
    noise, fps = loudest
    return {"inhibition_in_noise": {"noise": noise, "fps": fps, "share": shares[loudest]}}


def _rules(pairs: Sequence[Rendered]) -> dict[str, int]:
    """How samples are counted and errors arose, where that is not plain, and of how many targets."""
    return dict(Counter(rule for _, targets in pairs for target in targets for rule in target.rules))


def digest_of(stimulus: Stimulus) -> str:
    """What tells stimuli apart: their frames in hundredths of a grey level, beyond rounding, and their times."""
    frames = np.rint(100 * np.asarray(stimulus.frames, dtype=float)).astype(np.int32)
    return hashlib.sha256(frames.tobytes() + np.asarray(stimulus.time, dtype=float).tobytes()).hexdigest()[:16]


def _uncertainty(problem: Problem, z: Float[np.ndarray, " free"], slopes: Sensitivity, absolute: bool) -> Uncertainty:
    free = problem.free
    return linearised_uncertainty(
        free.names,
        z,
        free.unpacked,
        free.slopes(z),
        *known_rows(problem, slopes),
        n_effective=problem.samples(),
        absolute=absolute,
        priors=problem.priors,
        inside=problem.samples_inside(slopes.curves),
        minus_two_log_likelihood=problem.minus_two_log_likelihood(slopes.curves),
    )


@traced_once
def _hard_curves(problem: Problem, z: Float[Array, " free"]) -> Curves:
    model, observation = problem.at(z)
    hard = dataclasses.replace(model, thresholds=Hard())
    return problem.curves(hard, observation, problem.sums(hard))


def _curves(
    problem: Problem,
    observation: Observation,
    pairs: Sequence[Rendered],
    slopes: Sensitivity,
    hard: Curves,
    u: Uncertainty,
) -> tuple[Curve, ...]:
    """A curve for every target, in the order of the conditions."""
    curves = []
    for (stimulus, targets), places in zip(pairs, problem.places, strict=True):
        for target, (batch, slot, row) in zip(targets, places, strict=True):
            frames = slice(len(target.values))
            soft_curve = np.asarray(slopes.curves[batch][slot])[row, frames]
            hard_curve = np.asarray(hard[batch][slot])[row, frames]
            band = prediction_band(u, np.asarray(slopes.slopes[batch][slot])[row, frames])
            rest = rest_of(target.channel, observation)
            curves.append(curve_of(stimulus, target, soft_curve, hard_curve, band, rest))
    return tuple(curves)
