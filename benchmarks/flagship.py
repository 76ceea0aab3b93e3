"""How many of the 22 response properties one circuit with all mechanisms holds while it fits the target curves.

python -m benchmarks.flagship                              40 minutes on two cores, from the shipped start
python -m benchmarks.flagship --seeds 0 1 2 --minutes 60   three searches, each from the best of its own Sobol points
python -m benchmarks.flagship --without 5 15               asks for all properties but these
python -m benchmarks.flagship --table candidates.csv       goes on from the models of a table, and writes it anew
python -m benchmarks.flagship --table candidates.csv --front front.png      draws a table, and searches nothing

An evolution of the hard model by the misfit of `_flagship_misfit`. A model's pixels are dear, its cell is cheap: of
each candidate the cell is tried many times over stored MP(t) and F(t). A search from Sobol points looks at the first of
the four views alone for half of its time.
"""

import argparse
import csv
import itertools
import time
from collections.abc import Sequence
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

import lgmd2jax as lgmd
from benchmarks._evolution import Evolution, outside
from benchmarks._flagship_misfit import (
    EXAM,
    FREE,
    MODEL,
    PLAIN_LOOMS,
    PROBLEM,
    VIEWS,
    Candidate,
    Passed,
    everything,
    misfits,
    passed_on,
)
from benchmarks._front_figure import front_figure
from lgmd2jax._files.atomic import replaced
from lgmd2jax.fitting._search.points import sobol

SOBOL_POINTS, SOBOL_CELLS = 64, 256  # of the pixels, and of the cell for each: the best begins a search without a start
FROM_SOBOL, FROM_KNOWN = 0.1, 0.04  # of the unit box: the spread of the first candidates
CELLS = 64  # variants of a candidate
PATIENCE = 25  # generations without a better model, after which the evolution begins anew from the best one


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
