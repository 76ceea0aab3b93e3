"""Fits for tests, put together from small arrays: nothing is fitted."""

from collections.abc import Sequence
from typing import Any

import numpy as np

import lgmd2jax as lgmd
from lgmd2jax._channels import TARGETS, Channel
from lgmd2jax.fitting import Curve, Fit, Free, Run
from lgmd2jax.fitting._uncertainty.covariance import linearised_uncertainty


def curve(
    condition: str = "loom", channel: Channel = "smp_adapted", frames: int = 30, seed: int = 0, **changes: Any
) -> Curve:
    """A bump, missed a little by the soft model, of which the hard one is a copy; `changes` replace single arrays."""
    time = 10.0 * (np.arange(frames) - frames // 2)
    target = 0.5 + 0.4 * np.exp(-((time / 60) ** 2))
    soft = target + 0.02 * np.random.default_rng(seed).normal(size=frames)
    given = {
        "time": time,
        "target": target,
        "sem": np.full(frames, np.nan),
        "weight": np.ones(frames),
        "soft": soft,
        "hard": soft.copy(),
        "band": np.full(frames, 0.01),
        "error": np.full(frames, 0.02),
        "rest": TARGETS[channel].rest or 0.0,
    }
    return Curve(condition, channel, **(given | changes))


def run(
    loss: float = 1.0, history: tuple[tuple[float, ...], ...] = ((9.0, 4.0), (3.0, 2.0, 1.0)), free: int = 2
) -> Run:
    """A start that was descended."""
    return Run((0.5,) * free, (0.5,) * free, 20.0, loss, loss, history, "converged")


def fit_with(
    free: Free,
    curves: Sequence[Curve],
    *,
    z: Sequence[float] | None = None,
    jacobian: np.ndarray | None = None,
    observation: lgmd.Observation | None = None,
    runs: Sequence[Run] | None = None,
    screened: Sequence[float] = (1.5, 2.5, 30.0),
    temperatures: tuple[float, ...] = (0.5, 0.2),
    result: str = "converged",
    absolute: bool = False,
    misfit: float = 0.3,
    nonlinear: tuple[str, ...] = (),
) -> Fit:
    """A fit that ended at `z`, with the uncertainty of a Jacobian, by default one of full rank.

    `misfit`: standard deviation of the residuals, in standard errors, which are `absolute` or not.
    """
    p = len(free)
    place = np.full(p, 0.5) if z is None else np.array(z)
    generator = np.random.default_rng(1)
    if jacobian is None:
        jacobian = generator.normal(size=(50, p))
    parameters, observation = free.insert(lgmd.Parameters(), observation or lgmd.Observation(), place)
    return Fit(
        model=lgmd.LGMD2(parameters),
        observation=observation,
        free=free,
        z=place,
        start={parameter.name: float(parameter.value(0.25)) for parameter in free.parameters},
        loss=1.0,
        soft_loss=0.9,
        temperatures=temperatures,
        uncertainty=linearised_uncertainty(
            free.names,
            place,
            free.unpacked,
            free.slopes(place),
            jacobian,
            misfit * generator.normal(size=len(jacobian)),
            n_effective=len(jacobian) / 2,
            absolute=absolute,
        ),
        nonlinear=nonlinear,
        curves=tuple(curves),
        runs=tuple(runs if runs is not None else [run(free=p), run(3.0, free=p)]),
        screened=tuple(screened),
        errors={"smp_adapted": 0.02},
        result=result,
        stats={},
    )
