"""How many parameter sets a second a fit to labelled clips tries, over ten clips of 200 frames at 108 x 60 pixels.

python -m benchmarks.alarms              98 pixel stages with 1,024 cells each: 100,352 parameter sets
python -m benchmarks.alarms --points 16  fewer
"""

import argparse
import os
import time
from typing import Any

import jax
import numpy as np

import lgmd2jax as lgmd
from lgmd2jax._compute.tasks import Stop, Work
from lgmd2jax._compute.xla import set_flags
from lgmd2jax.alarms import LabelledClip, load_recipe
from lgmd2jax.alarms._cell_search import peaks_of, sums_at
from lgmd2jax.alarms._choice import choose
from lgmd2jax.alarms._problem import problem_of
from lgmd2jax.fitting._search.points import sobol

EYE = lgmd.Eye(60, 108, degrees_per_pixel=0.65, fps=30.0, projection="pinhole")
CLIPS, FRAMES, CELLS = 10, 200, 1024
WANTED_S = 20.0


def main() -> None:
    """Time the search; what is compiled once stands apart."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=98, help="pixel stages (default: %(default)s)")
    options = parser.parse_args()
    set_flags()
    jax.config.update("jax_enable_x64", True)
    recipe = load_recipe("video")
    films = list(lgmd.stimuli.encounters(EYE, jax.random.key(0), CLIPS, duration_ms=1000 * FRAMES / 30))
    labels: dict[str, Any] = {"windows": [(180, 199)], "silent": [(10, 150)]}
    clips = [LabelledClip.of(it.kind, np.asarray(it.stimulus.frames).astype(np.uint8), 30, **labels) for it in films]
    problem = problem_of(recipe.model, recipe.free, clips, 1.0, 1.0)
    points = sobol(len(recipe.free), options.points, (0,))
    pixels = list(problem.pixel_indices)
    start = recipe.free.place(recipe.model.parameters, lgmd.Observation())

    def screen(number: int, stop: Stop) -> dict:
        z = np.array(start)
        z[pixels] = points[number][pixels]
        peaks = np.asarray(
            peaks_of(problem, z, sums_at(problem, z), sobol(len(problem.cell_entries), CELLS, (0, number)))
        )
        return {"loss": float(choose(peaks, problem.wanted, problem.weights, 0.55, 0.95, 0.01).risk.min())}

    began = time.perf_counter()
    screen(0, None)
    compiled = time.perf_counter() - began
    began = time.perf_counter()
    with Work({}, True) as work:
        work.do("screening", screen, range(options.points))
    seconds = time.perf_counter() - began
    sets = options.points * CELLS
    print(f"{CLIPS} clips of {FRAMES} frames at 108x60, {os.cpu_count()} cores, float32 pixels, float64 cell")
    print(f"{sets} parameter sets in {seconds:.1f} s, {sets / seconds:.0f} a second; compiled in {compiled:.1f} s")
    hold = seconds * 100_000 / sets
    print(f"100,000 sets: {hold:.1f} s, wanted below {WANTED_S:g} s: {'holds' if hold < WANTED_S else 'does not hold'}")


if __name__ == "__main__":
    main()
