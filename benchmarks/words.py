"""Which sentences of the paper can its own circuit keep together, within Table I? A two-level search over hard models.

python -m benchmarks.words                 256 random pixel stages, 256 cells for each
python -m benchmarks.words --points 1024   more pixel stages

A sentence is kept where at least 90 % of its samples lie within its bands (stimuli/table1.toml). For each set of the
pixels' parameters all stimuli are shown once; the cell's are searched on the stored MP(t) and F(t). The first pixel
stage and the first cell are Table I's own. T_sp, which the potential does not depend on, is searched with the cell.
"""

import argparse
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from tqdm import tqdm

import lgmd2jax as lgmd
from lgmd2jax.fitting._problem import Problem, problem_of
from lgmd2jax.fitting._search.points import sobol, starting_points

_KEPT = 0.9  # share of samples
_AT_ONCE = 64  # cells side by side


class Sentences(eqx.Module):
    """The words, and for each slot of the problem the weight of a sample in the share of each sentence."""

    quotes: tuple[str, ...] = eqx.field(static=True)
    weights: list[Float[Array, "sentence condition time"]]


def sentences_of(problem: Problem, pairs) -> Sentences:
    """The sentences of a protocol whose conditions have one raster."""
    quotes = tuple(dict.fromkeys(target.quote for _, targets in pairs for target in targets))
    (batch,) = problem.batches
    weights = [np.zeros((len(quotes), *slot.scale.shape)) for slot in batch.slots]
    for (_, targets), places in zip(pairs, problem.places, strict=True):
        for target, place in zip(targets, places, strict=True):
            counted = np.asarray(batch.slots[place.slot].scale[place.row] > 0)
            weights[place.slot][quotes.index(target.quote), place.row] = counted
    counts = sum(weight.sum(axis=(1, 2)) for weight in weights)
    return Sentences(quotes, [jnp.asarray(weight / counts[:, None, None]) for weight in weights])


@eqx.filter_jit
def shares(
    problem: Problem, sentences: Sentences, z: Float[Array, " free"], cells: Float[Array, "count cell"]
) -> Float[Array, "count sentence"]:
    """The share of samples within the bands of each sentence, for each cell."""
    place = jnp.asarray(problem.cell_indices, dtype=int)
    sums = problem.sums(problem.at(z)[0])
    (batch,) = problem.batches

    def one(cell):
        (curves,) = problem.curves(*problem.at(z.at[place].set(cell)), sums)
        parts = zip(sentences.weights, batch.slots, curves, strict=True)
        return sum(jnp.einsum("sct,ct->s", weight, slot.inside(curve) * 1.0) for weight, slot, curve in parts)

    return jax.lax.map(one, cells, batch_size=_AT_ONCE)


def main() -> None:
    """Search, and print how often each sentence is kept, and the model that keeps most."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=256, help="pixel stages")
    parser.add_argument("--cells", type=int, default=256, help="cells for each")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    recipe: Any = lgmd.load_recipe("table1")
    problem = problem_of(recipe.model, recipe.observation, recipe.free, recipe.pairs, "squares")
    sentences = sentences_of(problem, recipe.pairs)
    start = recipe.free.place(recipe.model.parameters, recipe.observation)
    points = starting_points(problem, start, options.points, (options.seed,))
    place = list(problem.cell_indices)
    found_shares, found_z = [], []
    for number, z in enumerate(tqdm(points)):
        cells = sobol(len(place), options.cells, (options.seed, number))
        cells[0] = start[place]
        found_shares.append(np.asarray(shares(problem, sentences, jnp.asarray(z), jnp.asarray(cells))))
        whole = np.repeat(z[None], len(cells), axis=0)
        whole[:, place] = cells
        found_z.append(whole)
    table, every_z = np.concatenate(found_shares), np.concatenate(found_z)
    _report(sentences.quotes, table, every_z, recipe.free)


def _report(quotes: tuple[str, ...], table: np.ndarray, every_z: np.ndarray, free: lgmd.Free) -> None:
    kept = table >= _KEPT - 1e-9
    best = int(np.lexsort((table.mean(axis=1), np.minimum(table, _KEPT).sum(axis=1), kept.sum(axis=1)))[-1])
    print(f"{len(table)} models; the most that one keeps: {kept.sum(axis=1).max()} of {len(quotes)} sentences")
    print("most within | models that keep it | Table I | best model | sentence")
    for i, quote in enumerate(quotes):
        row = (table[:, i].max(), kept[:, i].mean(), table[0, i], table[best, i])
        print(" | ".join(f"{share:7.1%}" for share in row), "|", quote)
    print("sentences that exclude each other:")
    for i in range(len(quotes)):
        for j in range(i):
            if kept[:, i].any() and kept[:, j].any() and not (kept[:, i] & kept[:, j]).any():
                print(f"  {quotes[j][:50]} / {quotes[i][:50]}")
    values = {freedom.name: float(freedom.value(at)) for freedom, at in zip(free.freedoms, every_z[best], strict=True)}
    print("best model:", ", ".join(f"{name} {value:.4g}" for name, value in values.items()))


if __name__ == "__main__":
    jax.config.update("jax_enable_x64", True)
    main()
