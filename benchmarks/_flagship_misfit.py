"""What the flagship is searched by: the misfit of a model with all mechanisms to curves and properties together.

A sum of squares: what the curves of stimuli/lgmd2.toml lack, and by how much each property misses a margin within its
bounds, with objects as they are, half a pixel aside, and in two other draws of noise and texture.
"""

import dataclasses
import functools
from collections.abc import Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

import lgmd2jax as lgmd
from lgmd2jax._characterise import trials
from lgmd2jax._characterise.curves import curves_of
from lgmd2jax._characterise.exam import Exam, ExamSums, at_rate
from lgmd2jax._characterise.measures_looming import LOOMS, angles_at_peak
from lgmd2jax._characterise.properties import ROWS
from lgmd2jax._characterise.row import Row
from lgmd2jax._characterise.verdicts import judge
from lgmd2jax._compute import xla
from lgmd2jax._network.stages import Sums
from lgmd2jax.fitting._conditions import render
from lgmd2jax.fitting._problem import Curves, problem_of

xla.set_flags()
SHIPPED = lgmd.load_fit("lgmd2")
MODEL, FREE = SHIPPED.model, SHIPPED.free
CONDITIONS = render(lgmd.load_protocol("lgmd2").conditions)
PROBLEM = problem_of(MODEL, lgmd.Observation(), FREE, CONDITIONS, "squares")
EYE = lgmd.Eye(rows=48, cols=64, degrees_per_pixel=2.0, fps=100.0)
EXAM = Exam(EYE)  # whose windows and bounds hold for the other views too
VIEWS = {"rows": EXAM, "aside": Exam(EYE, shift=0.5), "noise 1": Exam(EYE, seed=1), "noise 2": Exam(EYE, seed=2)}
PLAIN_LOOMS = (20, 40, 80)  # ms, the l/|v| of the dark looms: the first conditions of the protocol

ROW_WEIGHT = 20.0  # of what a property lacks, as a share of its bound, beside 1 - R2 of a loom
MARGIN = 0.05  # of a bound: how far within it a property is wished
LAW = ((3.4, 5.4), (18.0, 32.0))  # of alpha, and of delta in ms: a little inside of what is asked of the flagship
ONE_ANGLE = 4.5  # degrees: range of the threshold angle over l/|v|
WEIGHT_IN_NOISE, WEIGHT_ELSEWHERE = 0.5, 0.2  # of the loom in noise, and of what is known by a word alone
HALF = 0.48  # of silence's RMSE, where a response is asked
QUIET, TOO_LOUD = 0.028, 0.03  # of the potential, where quiet is asked; beyond, what counts as a whole miss


class Passed(NamedTuple):
    """What the pixels pass on: of each view of the exam, stacked, and of the conditions of the fit."""

    views: ExamSums
    conditions: tuple[Sums, ...]


class Told(NamedTuple):
    """Which properties hold and alpha and delta in each view; R2 of the dark looms; range of the threshold angle."""

    holds: Bool[Array, "view row"]
    law: Float[Array, "view 2"]
    spread: Float[Array, " view"]
    r2: Float[Array, " loom"]


@dataclasses.dataclass(frozen=True, eq=False)
class Candidate:
    """A point of the unit box, its residuals, what its pixels pass on, and what is told of it."""

    z: Float[np.ndarray, " free"]
    residuals: Float[np.ndarray, " residual"]
    passed: Passed
    told: Told

    @property
    def misfit(self) -> float:
        """The sum of squares that the search makes small."""
        return float(np.square(self.residuals).sum())

    @property
    def held(self) -> int:
        """How many properties hold in each view."""
        return int(self.told.holds.sum(axis=1).min())

    def row(self) -> dict[str, str | int]:
        """The candidate as a row of a table."""
        row: dict[str, str | int] = {name: int(held.sum()) for name, held in zip(VIEWS, self.told.holds, strict=False)}
        row |= {
            "missing": " ".join(str(row.number) for row, held in zip(ROWS, self.told.holds[0], strict=True) if not held)
        }
        row |= {"alpha": f"{self.told.law[0, 0]:.2f}", "delta": f"{self.told.law[0, 1]:.1f}"}
        row |= {f"r2_{loom}": f"{r2:.3f}" for loom, r2 in zip(PLAIN_LOOMS, self.told.r2, strict=True)}
        return row | {name: f"{value:.5g}" for name, value in FREE.values(self.z).items()}

    def __str__(self):
        return f"{self.misfit:9.3f}  " + ", ".join(f"{name} {value}" for name, value in self.row().items())


def at(z) -> lgmd.AbstractNetwork:
    """The model at a point."""
    return PROBLEM.at(z, None)[0]


@functools.partial(jax.jit, static_argnames="fps")
def trial_sums(z, frames, fps):
    """MP and F of a trial."""
    return at_rate(at(z), EXAM, fps).sums(frames, jnp.asarray(1000 / fps))[0]


condition_sums = jax.jit(lambda z: PROBLEM.sums(at(z)))


@functools.cache
def frames_of(trial: trials.Trial) -> Float[Array, "time row col"]:
    """What a trial shows, rendered and moved to the device once."""
    return jnp.asarray(trial.frames(EYE))


def passed_on(z, views: Sequence[Exam]) -> Passed:
    """Sums of views and conditions; other noise is shown in those trials alone that have any."""
    plain: dict[str, Sums] = {}
    stacked = []
    for exam in views:
        groups = []
        for group in exam.groups:
            sums = []
            for trial in group:
                if exam.seed and not _depends_on_seed(trial):
                    sums.append(plain[trial.name])
                    continue
                sums.append(jax.device_get(trial_sums(z, frames_of(trial), trial.fps)))
                if exam is EXAM:
                    plain[trial.name] = sums[-1]
            groups.append(jax.tree.map(lambda *each: np.stack(each), *sums))
        stacked.append(tuple(groups))
    return Passed(jax.tree.map(lambda *each: np.stack(each), *stacked), jax.device_get(condition_sums(z)))


def _depends_on_seed(trial: trials.Trial) -> bool:
    return trial.textured or trial.name in (trials.STILL, trials.DRIFTING)


def row_lacks(row: Row, values: Float[Array, " line"]) -> Float[Array, " _line"]:
    """By how much each judged line misses its margin, as a share of its bound; of alternatives the least."""
    lacks = []
    for place, (line, value) in enumerate(zip(row.lines, values, strict=True)):
        if line.judged:
            low, high, margin = (*LAW[place], 0.0) if row.number == 2 else (line.low, line.high, MARGIN)
            scale = max(*(abs(end) for end in (low, high) if np.isfinite(end)), 0.05, 0.0)
            lack = jnp.maximum(jnp.maximum(low - value, value - high) / scale + margin, 0)
            far = jnp.minimum(1 + jnp.log(jnp.maximum(lack, 1)), 4)  # so that one line does not drown the others
            lacks.append(jnp.nan_to_num(jnp.where(lack > 1, far, lack), nan=3.0))
    lacks = jnp.stack(lacks)
    return jnp.min(lacks, keepdims=True) if row.holds_if == "any line holds" else lacks


def view_residuals(sums: ExamSums, model: lgmd.AbstractNetwork, without: Sequence[int]):
    """What the properties lack in a view, and whether they hold, alpha and delta, and the spread of the angle."""
    curves = curves_of(EXAM, sums, model)
    values, holds = judge(curves)
    lacks = [row_lacks(row, each) for row, each in zip(ROWS, values, strict=True) if row.number not in without]
    spread = jnp.ptp(angles_at_peak(curves, *LOOMS, l_over_v=np.array(trials.L_OVER_V)))
    lacks.append(jnp.maximum(jnp.nan_to_num(spread, nan=20.0) - ONE_ANGLE, 0)[None] / 20)
    return ROW_WEIGHT * jnp.concatenate(lacks), holds, values[_LAW], spread


_LAW = next(i for i, row in enumerate(ROWS) if row.number == 2)
_TARGETS = jax.tree.map(np.asarray, [[(slot.scale, slot.low) for slot in batch.slots] for batch in PROBLEM.batches])


def curve_residuals(curves: Curves) -> tuple[Float[Array, " residual"], Float[Array, " loom"]]:
    """What the potential lacks; and R2 of the dark looms.

    A dark loom's squares sum up to 1 - R2. Elsewhere it is enough to be within half of silence's RMSE, and near rest.
    """
    residuals, r2 = [], []
    for (stimulus, targets), places in zip(CONDITIONS, PROBLEM.places, strict=True):
        for target, place in zip(targets, places, strict=True):
            if target.channel != "smp_adapted":
                continue
            scale, wanted = (each[place.row] for each in _TARGETS[place.batch][place.slot])
            counts = scale > 0
            missed = jnp.where(counts, curves[place.batch][place.slot][place.row] - wanted, 0)
            rmse = jnp.sqrt(jnp.square(missed).sum() / counts.sum() + 1e-12)
            silence = np.sqrt(np.mean(np.square(wanted[counts] - 0.5)))
            if stimulus.name.startswith("dark approach"):
                unexplained = missed / (np.sqrt(counts.sum()) * wanted[counts].std())
                residuals.append((WEIGHT_IN_NOISE if "noise" in stimulus.name else 1.0) * unexplained)
                r2.append(1 - jnp.square(unexplained).sum())
            elif silence > 1e-4:
                residuals.append(WEIGHT_ELSEWHERE * jnp.maximum(rmse / silence - HALF, 0)[None])
            else:
                residuals.append(WEIGHT_ELSEWHERE * jnp.clip((missed.max() - QUIET) / TOO_LOUD, 0, 3)[None])
    return jnp.concatenate(residuals), jnp.stack(r2[: len(PLAIN_LOOMS)])


def _everything(z, passed: Passed, without: tuple[int, ...], weight) -> tuple[Float[Array, " residual"], Told]:
    model = at(z)
    lacks, holds, law, spread = jax.lax.map(
        lambda sums: view_residuals(sums, model, without), passed.views, batch_size=8
    )
    missed, r2 = curve_residuals(PROBLEM.curves(model, lgmd.Observation(), passed.conditions))
    lacks = lacks.ravel() * np.sqrt(len(VIEWS) / len(lacks))  # fewer views weigh as much as all
    return jnp.concatenate([weight * missed, lacks]), Told(holds, law, spread, r2)


everything = jax.jit(_everything, static_argnames="without")


@functools.partial(jax.jit, static_argnames="without")
def misfits(points: Float[Array, "point free"], passed: Passed, without: tuple[int, ...], weight):
    """The sum of squares of points that share their pixels."""
    return jax.lax.map(lambda z: jnp.square(_everything(z, passed, without, weight)[0]).sum(), points, batch_size=8)
