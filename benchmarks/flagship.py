"""How many of the 22 response properties and how much of the curves can one circuit with all mechanisms meet?

python -m benchmarks.flagship                 40 minutes on two cores
python -m benchmarks.flagship --curves 3      more weight on the curves of stimuli/lgmd2.toml

An evolution on two levels: for each set of the pixels' parameters all stimuli pass once, as they are and half a pixel
aside; 96 cells are then tried on the stored MP(t) and F(t). The score counts properties, their distance from the
bounds, and what the curves lack. It sets out from a prototype that holds 21 as they are and 19 aside; `fits/lgmd2.toml`
sets out from where it led.
"""

import argparse
import dataclasses
import time

import jax
import jax.numpy as jnp
import numpy as np

import lgmd2jax as lgmd
from lgmd2jax._characterise.exam import Exam, sums_of
from lgmd2jax._characterise.properties import ROWS
from lgmd2jax._characterise.verdicts import verdicts
from lgmd2jax._compute import xla
from lgmd2jax.fitting._conditions import render
from lgmd2jax.fitting._problem import Problem, problem_of

xla.set_flags()
jax.config.update("jax_enable_x64", True)
EYE = lgmd.Eye(rows=48, cols=64, degrees_per_pixel=2.0, fps=100.0)
FREE = lgmd.Free(**dict.fromkeys(  # k stays, since a common factor of theta, T_s and k changes nothing
    ("theta1", "theta2", "theta3", "tau1", "w_bias", "sigma1", "T_s", "T_p", "tau_hold", "tau2", "tau3", "A_ffi",
     "T_sfa", "gamma", "m", "tau_cell", "lag"), None,
))  # fmt: skip
START = lgmd.Parameters(
    k=0.3, theta2=1.92, tau1=23.1, w_bias=0.124, sigma1=0.0457, T_s=7.89, T_p=19.4, tau_hold=250.0, tau2=5.0,
    tau3=773.0, A_ffi=0.0907, T_sfa=0.00216, gamma=0.646, m=4.47, tau_cell=26.5, lag=30.0,
)  # fmt: skip
MODEL = lgmd.LGMD2(START, mechanisms=lgmd.MECHANISMS, eye=EYE)
CELLS, KEPT = 96, 24
ALPHA, DELTA = 3.4, 18.0  # and more, ms, aimed at; a little inside of what is asked of the flagship
_SLOPE = next(i for i, row in enumerate(ROWS) if row.number == 2)


@dataclasses.dataclass(frozen=True)
class Candidate:
    """A point of the unit box, its score, the properties it misses (as they are; half a pixel aside), and the loss."""

    z: np.ndarray
    score: float
    missing: tuple[list[int], list[int]]
    loss: float


def at(z) -> lgmd.LGMD2:
    """The model at a point."""
    parameters, _ = FREE.insert(MODEL.parameters, lgmd.Observation(), z)
    return dataclasses.replace(MODEL, parameters=parameters)


def row_score(row, values, holds):
    """1 for a property that holds, up to .15 more for its distance from the bounds; else up to .4, as it is nearer."""
    inside, outside = [], []
    for line, value in zip(row.lines, values, strict=True):
        if line.judged:
            ends = jnp.array([line.low, line.high])
            scale = max(*(abs(end) for end in (line.low, line.high) if np.isfinite(end)), 0.05, 0.0)
            room = jnp.min(jnp.array([value - ends[0], ends[1] - value])) / scale
            room = jnp.where(jnp.isfinite(room), room, -1)
            inside.append(jnp.clip(room / 0.08, 0, 1))
            outside.append(jnp.clip(-room, 0, 1))
    return jnp.where(holds, 1 + 0.15 * jnp.min(jnp.stack(inside)), 0.4 * (1 - jnp.max(jnp.stack(outside))))


def scorer(exam: Exam):
    """Scores, verdicts and the law of peak times of cells, by what the pixels summed."""

    @jax.jit
    def of(sums, cells):
        def one(z):
            values, holds = verdicts(exam, sums, at(z))
            scores = [row_score(row, value, held) for row, value, held in zip(ROWS, values, holds, strict=True)]
            alpha, delta = values[_SLOPE]
            law = 2 * jnp.maximum(ALPHA - alpha, 0) + 0.1 * jnp.clip(DELTA - delta, 0, 30)
            return jnp.sum(jnp.stack(scores)) - jnp.nan_to_num(law, nan=10.0), holds

        return jax.lax.map(one, cells, batch_size=16)

    return of


def curve_losses(problem: Problem):
    """Half the sum of squares of cells, a thousandth of it: what the curves lack."""

    @jax.jit
    def of(sums, cells):
        def one(z):
            return jnp.square(problem.differences(problem.curves(at(z), lgmd.Observation(), sums))).sum() / 2000

        return jax.lax.map(one, cells, batch_size=32)

    return of


def main() -> None:
    """Search, and print each better model."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=40.0)
    parser.add_argument("--curves", type=float, default=1.0, help="weight of the curves (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    exams = Exam(EYE), Exam(EYE, shift=0.5)
    problem = problem_of(MODEL, lgmd.Observation(), FREE, render(lgmd.load_protocol("lgmd2").conditions), "squares")
    scorers, losses_of = [scorer(exam) for exam in exams], curve_losses(problem)
    pixel_sums = jax.jit(lambda z: problem.sums(at(z)))
    chance, best, end = np.random.default_rng(options.seed), [], time.monotonic() + 60 * options.minutes
    pixels, cell = list(problem.pixel_indices), list(problem.cell_indices)
    while time.monotonic() < end:
        if best:
            weights = np.exp(-np.arange(len(best)) / 5.0)
            z = best[chance.choice(len(best), p=weights / weights.sum())].z.copy()
            steps = chance.choice([0.01, 0.03, 0.1]) * chance.standard_normal(len(pixels))
            z[pixels] += steps * (chance.random(len(pixels)) < 0.5)
        else:
            z = FREE.place(START, lgmd.Observation())
        cells = np.tile(z, (CELLS, 1))
        spread = chance.choice([0.005, 0.015, 0.05, 0.15], (CELLS, 1)) * chance.standard_normal((CELLS, len(cell)))
        cells[1:, cell] += (spread * (chance.random(spread.shape) < 0.6))[1:]
        cells = np.clip(np.abs(cells), 0, 1)
        rows = [of(sums_of(exam, at(cells[0])), cells) for exam, of in zip(exams, scorers, strict=True)]
        losses = np.asarray(losses_of(pixel_sums(cells[0]), cells))
        total = sum(np.asarray(score) for score, _ in rows) - options.curves * losses
        place = int(np.nanargmax(total))
        missing = [[row.number for row, held in zip(ROWS, holds[place], strict=True) if not held] for _, holds in rows]
        candidate = Candidate(cells[place], float(total[place]), (missing[0], missing[1]), float(losses[place]))
        best = sorted([*best, candidate], key=lambda each: -each.score)[:KEPT]
        if best[0] is candidate:
            values = {name: float(f"{value:.5g}") for name, value in FREE.values(candidate.z).items()}
            lacks = f"missing {missing[0]}, aside {missing[1]}; curves {candidate.loss:.2f}"
            print(f"{candidate.score:7.2f}  {lacks}; {values}", flush=True)


if __name__ == "__main__":
    main()
