"""Which sentences of the paper its own circuit keeps together within Table I: a search over hard models.

python -m benchmarks.paper_sentences                 256 random pixel stages, 256 near the best, 256 cells for each
python -m benchmarks.paper_sentences --points 1024   more of the random ones

A sentence is kept where at least 90 % of its samples lie within its bands (stimuli/table1.toml). For each set of the
pixels' parameters all stimuli are shown once; the cell's are searched on the stored MP(t) and F(t). The first model is
Table I itself. A near set steps from the model that has most samples of one sentence within, of each sentence in turn.
"""

import argparse
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float
from tqdm import tqdm

import lgmd2jax as lgmd
from lgmd2jax.fitting._problem import Problem, problem_of
from lgmd2jax.fitting._search.points import sobol, starting_points

_KEPT = 0.9  # share of samples
_AT_ONCE = 64  # cells side by side
_NEAR = 0.08  # of the range: steps from a best model


class Sentences(eqx.Module):
    """The quoted sentences, and for each slot of the problem the weight of a sample in the share of each sentence."""

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
    counts = np.sum([weight.sum(axis=(1, 2)) for weight in weights], axis=0)
    return Sentences(quotes, [jnp.asarray(weight / counts[:, None, None]) for weight in weights])


class Kept(NamedTuple):
    """Of each sentence the share of samples within its bands, and how far from one the farthest sample lies."""

    share: Float[Array, "*count sentence"]
    farthest: Float[Array, "*count sentence"]


@eqx.filter_jit
def kept_by(
    problem: Problem, sentences: Sentences, z: Float[Array, " free"], cells: Float[Array, "count cell"]
) -> Kept:
    """What each cell keeps, at the pixels' parameters of `z`."""
    place = jnp.asarray(problem.cell_indices, dtype=int)
    sums = problem.sums(problem.at(z)[0])
    (batch,) = problem.batches

    def one(cell):
        (curves,) = problem.curves(*problem.at(z.at[place].set(cell)), sums)
        share, farthest = jnp.zeros((2, len(sentences.quotes)))
        for weight, slot, curve in zip(sentences.weights, batch.slots, curves, strict=True):
            share += jnp.einsum("sct,ct->s", weight, slot.inside(curve) * 1.0)
            distance = jnp.abs(curve - slot.nearest(curve))
            farthest = jnp.maximum(farthest, jnp.where(weight > 0, distance, 0).max(axis=(1, 2)))
        return Kept(share, farthest)

    return jax.lax.map(one, cells, batch_size=_AT_ONCE)


class Search:
    """The models of a search, in the unit box, and what each keeps."""

    def __init__(self, cells: int, seed: int):
        self.recipe: Any = lgmd.load_recipe("table1")
        free, observation = self.recipe.free, self.recipe.observation
        self.problem = problem_of(self.recipe.model, observation, free, self.recipe.pairs, "squares")
        self.sentences = sentences_of(self.problem, self.recipe.pairs)
        self.start = free.place(lgmd.preset("lgmd2"), observation)  # the recipe sets out from what was found here
        self.cells, self.seed = cells, seed
        self.share, self.farthest = np.zeros((2, 0, len(self.sentences.quotes)))
        self.models = np.zeros((0, len(free)))

    def add(self, z: Float[np.ndarray, " free"], number: int) -> None:
        """The models with the pixels' parameters of `z`, the cell of which is the first."""
        place = list(self.problem.cell_indices)
        cells = sobol(len(place), self.cells, (self.seed, number))
        cells[0] = z[place]
        kept = kept_by(self.problem, self.sentences, jnp.asarray(z), jnp.asarray(cells))
        models = np.repeat(z[None], len(cells), axis=0)
        models[:, place] = cells
        self.share, self.farthest = np.vstack([self.share, kept.share]), np.vstack([self.farthest, kept.farthest])
        self.models = np.vstack([self.models, models])

    @property
    def is_kept(self) -> Bool[np.ndarray, "model sentence"]:
        """Which sentences each model keeps."""
        return self.share >= _KEPT - 1e-9

    def best(self, sentence: int | None = None) -> int:
        """The model that keeps most sentences, or of one sentence the most samples; of equals, most samples in all."""
        first = self.is_kept.sum(axis=1) if sentence is None else self.share[:, sentence]
        return int(np.lexsort((self.share.mean(axis=1), np.minimum(self.share, _KEPT).sum(axis=1), first))[-1])


def main() -> None:
    """Search, and print how often each sentence is kept, and the model that keeps most."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=256, help="pixel stages anywhere within Table I")
    parser.add_argument("--near", type=int, default=256, help="pixel stages near the best model of one sentence")
    parser.add_argument("--cells", type=int, default=256, help="cells for each")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    search, random = Search(options.cells, options.seed), np.random.default_rng(options.seed)
    points = starting_points(search.problem, search.start, options.points, (options.seed,))
    for number in tqdm(range(options.points + options.near)):
        if number < options.points:
            z = points[number]
        else:
            best = search.models[search.best(number % len(search.sentences.quotes))]
            z = np.clip(best + _NEAR * random.normal(size=len(best)), 0, 1)
        search.add(z, number)
    _report(search)


def _report(search: Search) -> None:
    share, farthest, is_kept, best = search.share, search.farthest, search.is_kept, search.best()
    quotes = search.sentences.quotes
    print(f"{len(share)} models; the most that one keeps: {is_kept.sum(axis=1).max()} of {len(quotes)} sentences")
    columns = "most | Table I | best model"
    print(f"within: {columns} || models that keep it || farthest: least{columns.removeprefix('most')} || sentence")
    for i, quote in enumerate(quotes):
        within = " | ".join(f"{part:7.1%}" for part in (share[:, i].max(), share[0, i], share[best, i]))
        outside = " | ".join(f"{part:6.3f}" for part in (farthest[:, i].min(), farthest[0, i], farthest[best, i]))
        print(f"{within} || {is_kept[:, i].mean():7.1%} || {outside} || {quote}")
    print("sentences that exclude each other:")
    for i in range(len(quotes)):
        for j in range(i):
            if is_kept[:, i].any() and is_kept[:, j].any() and not (is_kept[:, i] & is_kept[:, j]).any():
                print(f"  {quotes[j]} / {quotes[i]}")
    places = zip(search.recipe.free.parameters, search.models[best], strict=True)
    values = {parameter.name: float(parameter.value(place)) for parameter, place in places}
    print("best model:", ", ".join(f"{name} {value:.4g}" for name, value in values.items()))


if __name__ == "__main__":
    jax.config.update("jax_enable_x64", True)
    main()
