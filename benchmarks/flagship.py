"""How many of the 22 response properties and how much of the curves can one circuit with all mechanisms meet?

python -m benchmarks.flagship                              40 minutes on two cores, from the shipped start
python -m benchmarks.flagship --seeds 0 1 2 --minutes 60   three searches, each from the best of its own Sobol points
python -m benchmarks.flagship --without 5 15               asks for all properties but these
python -m benchmarks.flagship --table candidates.csv       goes on from the models of a table, and writes it anew
python -m benchmarks.flagship --table candidates.csv --front front.png      draws a table, and searches nothing

An evolution of the hard model. Its misfit is a sum of squares: what the curves of stimuli/lgmd2.toml lack, and by how
much each property misses a margin within its bounds, with objects as they are, half a pixel aside, and in two other
draws of noise and texture. A model's pixels are dear, its cell is cheap: of each candidate the cell is tried many times
over stored MP(t) and F(t). A search from Sobol points looks at the first view alone for half of its time.
"""

import argparse
import csv
import dataclasses
import functools
import itertools
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

import lgmd2jax as lgmd
from benchmarks._evolution import Evolution, outside
from benchmarks._front_figure import front_figure
from lgmd2jax._characterise import trials
from lgmd2jax._characterise.curves import curves_of
from lgmd2jax._characterise.exam import Exam, ExamSums, at_rate
from lgmd2jax._characterise.measures_looming import LOOMS, angles_at_peak
from lgmd2jax._characterise.properties import ROWS
from lgmd2jax._characterise.row import Row
from lgmd2jax._characterise.verdicts import judge
from lgmd2jax._compute import xla
from lgmd2jax._files.atomic import replaced
from lgmd2jax._network.stages import Sums
from lgmd2jax.fitting._conditions import render
from lgmd2jax.fitting._problem import Curves, problem_of
from lgmd2jax.fitting._search.points import sobol

xla.set_flags()
SHIPPED = lgmd.load_fit("lgmd2")
MODEL, FREE = SHIPPED.model, SHIPPED.free
CONDITIONS = render(lgmd.load_protocol("lgmd2").conditions)
PROBLEM = problem_of(MODEL, lgmd.Observation(), FREE, CONDITIONS, "squares")
EYE = lgmd.Eye(rows=48, cols=64, degrees_per_pixel=2.0, fps=100.0)
EXAM = Exam(EYE)  # whose windows and bounds hold for the other views too
VIEWS = {"rows": EXAM, "aside": Exam(EYE, shift=0.5), "noise 1": Exam(EYE, seed=1), "noise 2": Exam(EYE, seed=2)}
PLAIN_LOOMS = (20, 40, 80)  # ms, the l/|v| of the dark looms: the first conditions of the protocol
SOBOL_POINTS, SOBOL_CELLS = 64, 256  # of the pixels, and of the cell for each: the best begins a search without a start

ROW_WEIGHT = 20.0  # of what a property lacks, as a share of its bound, beside 1 - R2 of a loom
MARGIN = 0.05  # of a bound: how far within it a property is wished
LAW = ((3.4, 5.4), (18.0, 32.0))  # of alpha, and of delta in ms: a little inside of what is asked of the flagship
ONE_ANGLE = 4.5  # degrees: range of the threshold angle over l/|v|
WEIGHT_IN_NOISE, WEIGHT_ELSEWHERE = 0.5, 0.2  # of the loom in noise, and of what is known by a word alone
HALF = 0.48  # of silence's RMSE, where a response is asked
QUIET, TOO_LOUD = 0.028, 0.03  # of the potential, where quiet is asked; beyond, what counts as a whole miss

FROM_SOBOL, FROM_KNOWN = 0.1, 0.04  # of the unit box: the spread of the first candidates
CELLS = 64  # variants of a candidate
PATIENCE = 25  # generations without a better model, after which the evolution begins anew from the best one


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
def frames_of(exam: Exam, trial: trials.Trial) -> Float[Array, "time row col"]:
    """What a view shows, rendered and moved to the device once."""
    return jnp.asarray(exam.frames(trial))


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
                sums.append(jax.device_get(trial_sums(z, frames_of(exam, trial), trial.fps)))
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


class Search:
    """What a search asks for; `front`: of all models that were seen in all views, those that no other one excels.

    **Arguments:** `curves`: weight of the curves beside the properties. `without`: numbers of the properties that are
    not asked for.
    """

    def __init__(self, curves: float, without: Sequence[int]):
        self.settings = tuple(without), jnp.asarray(curves)
        self.views = tuple(VIEWS.values())
        self.front: list[Candidate] = []

    def candidate(self, z: Float[np.ndarray, " free"], passed: Passed | None = None) -> Candidate:
        """A point, judged; by what its pixels pass on where that is known."""
        passed = passed or passed_on(jnp.asarray(z), self.views)
        residuals, told = jax.device_get(everything(jnp.asarray(z), passed, *self.settings))
        candidate = Candidate(z, residuals, passed, told)
        if len(self.views) == len(VIEWS):
            self.front = _front([*self.front, candidate])
        return candidate

    def best_variant(self, variants: Float[np.ndarray, "variant free"]) -> tuple[int, float, Passed]:
        """Of points that share their pixels the best one and its misfit, and what these pixels pass on."""
        within = np.clip(variants, 0, 1)
        passed = passed_on(jnp.asarray(within[0]), self.views)
        scores = np.asarray(misfits(jnp.asarray(within), passed, *self.settings))
        scores = np.nan_to_num(scores, nan=np.inf) + outside(variants)
        return (i := int(np.argmin(scores))), scores[i], passed

    def beginning(self, seed: int) -> Candidate:
        """The best of Sobol points: of the pixels, and of the cell for each."""
        points, best = sobol(len(FREE), SOBOL_POINTS * SOBOL_CELLS, (seed,)), None
        cell = np.array(PROBLEM.cell_indices)
        for variants in np.split(points, SOBOL_POINTS):
            shared = np.tile(variants[0], (SOBOL_CELLS, 1))
            shared[:, cell] = variants[:, cell]
            i, misfit, passed = self.best_variant(shared)
            if best is None or misfit < best.misfit:
                best = self.candidate(shared[i], passed)
        assert best is not None
        return best

    def generation(self, evolution: Evolution, best: Candidate) -> Candidate:
        """The best model after a generation."""
        chosen, values = [], []
        for variants in evolution.ask():
            i, misfit, passed = self.best_variant(variants)
            chosen.append(variants[i])
            values.append(misfit)
            if misfit < best.misfit:
                best = min(best, self.candidate(np.clip(variants[i], 0, 1), passed), key=lambda each: each.misfit)
        evolution.tell(np.stack(chosen), np.array(values))
        return best


def _front(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Those that no other one excels in properties and in the least R2 of the dark looms."""
    ordered = sorted(candidates, key=lambda each: (-each.held, -each.told.r2.min()))
    front: list[Candidate] = []
    for each in ordered:
        if not front or each.told.r2.min() > front[-1].told.r2.min():
            front.append(each)
    return front


def read_table(table: Path) -> list[dict[str, str]]:
    """Its rows."""
    with open(table, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def point_of(row: dict[str, str]) -> Float[np.ndarray, " free"]:
    """The model of a row, as a point of the unit box."""
    return np.array([np.clip(free.place(float(row[free.name])), 0, 1) for free in FREE.parameters])


def draw(table: Path, figure: Path) -> None:
    """The front that a table holds."""
    rows = read_table(table)
    held = np.array([min(int(row[view]) for view in VIEWS) for row in rows])
    r2 = np.array([[float(row[f"r2_{loom}"]) for loom in PLAIN_LOOMS] for row in rows])
    front_figure(figure, held, r2, PLAIN_LOOMS)


def write_table(table: Path, candidates: Sequence[Candidate]) -> None:
    """A row a model: those that no other one excels, the one that holds most properties first, then the best."""
    rows = [candidate.row() for candidate in candidates]
    with replaced(table) as path, open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def run(options: argparse.Namespace, seed: int, known: Sequence[Float[np.ndarray, " free"]]) -> Candidate:
    """One search, from the best of the given points or of Sobol points of its own; each better model is printed."""
    search, begun = Search(options.curves, options.without), time.monotonic()
    if known:
        best = min((search.candidate(z) for z in known), key=lambda candidate: candidate.misfit)
    else:
        search.views = (EXAM,)
        best = search.beginning(seed)
    chance = itertools.count(seed, 1000)

    def evolution_from(z: Float[np.ndarray, " free"], spread: float) -> Evolution:
        return Evolution(z, spread, np.array(PROBLEM.cell_indices), variants=CELLS, seed=next(chance))

    evolution, better_at = evolution_from(best.z, FROM_KNOWN if known else FROM_SOBOL), 0
    print(f"    start  {best}", flush=True)
    while (minutes := (time.monotonic() - begun) / 60) < options.minutes:
        if len(search.views) < len(VIEWS) and minutes > options.minutes / 2:
            search.views = tuple(VIEWS.values())
            best = search.candidate(best.z)
            evolution, better_at = evolution_from(best.z, FROM_KNOWN), 0
            print(f"all views  {best}", flush=True)
        after = search.generation(evolution, best)
        if after is not best:
            better_at = evolution.generation
            print(f"{minutes:5.1f} min {after}", flush=True)
        best = after
        if evolution.generation - better_at > PATIENCE:
            evolution, better_at = evolution_from(best.z, FROM_KNOWN), 0
        if options.table and search.front:
            write_table(options.table, [*search.front, *([] if best in search.front else [best])])
    return best


def main() -> None:
    """Search, or draw a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=40.0, help="for each seed (default: %(default)g)")
    parser.add_argument("--curves", type=float, default=1.0, help="weight of the curves (default: %(default)g)")
    parser.add_argument("--without", type=int, nargs="*", default=[5, 13], help="properties let go (default: 5 13)")
    parser.add_argument("--seeds", type=int, nargs="*", help="of searches from Sobol points; none: from a known start")
    parser.add_argument("--table", type=Path, help="CSV of the models that no other one excels")
    parser.add_argument("--front", type=Path, help="draw the table, and search nothing")
    options = parser.parse_args()
    if options.front:
        if not options.table:
            parser.error("--front draws a table; name one, --table FILE")
        draw(options.table, options.front)
        return
    if not options.seeds:
        known = (
            [point_of(row) for row in read_table(options.table)] if options.table and options.table.is_file() else []
        )
        run(options, 0, known or [FREE.place(MODEL.parameters, lgmd.Observation())])
    for seed in options.seeds or ():
        print(f"seed {seed}: {run(options, seed, [])}", flush=True)


if __name__ == "__main__":
    main()
