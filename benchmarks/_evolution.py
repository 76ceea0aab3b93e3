"""An evolution strategy for functions of which some variables are dear to change and others cheap."""

import numpy as np
from jaxtyping import Float, Int

POPULATION, PARENTS = 12, 6  # candidates of a generation, and how many of them move the mean
LEAST_SPREAD = 0.002  # of the unit box
OUTSIDE = 50.0  # added to the value for a squared distance of 1 from the box


class Evolution:
    """CMA-ES in the unit box (Hansen 2016, arXiv 1604.00772).

    Each candidate of a generation comes in many variants: they share the dear variables, and their cheap ones are drawn
    from the distribution of these given the dear ones. `tell` takes the best variant of each candidate.

    **Arguments:** `mean`, `spread`: where the search begins, and the standard deviation of the first draws. `cheap`:
    indices of the cheap variables. `variants`: of a candidate.
    """

    def __init__(
        self,
        mean: Float[np.ndarray, " variable"],
        spread: float,
        cheap: Int[np.ndarray, " _"],
        variants: int,
        seed: int,
    ):
        self.mean, self.spread, self.variants = np.array(mean), spread, variants
        self.chance, size = np.random.default_rng(seed), len(mean)
        self.cheap, self.dear = cheap, np.setdiff1d(np.arange(size), cheap)
        weights = np.log(PARENTS + 0.5) - np.log(np.arange(1, PARENTS + 1))
        self.weights = weights / weights.sum()
        self.covariance, self.path, self.spread_path = np.eye(size), np.zeros(size), np.zeros(size)
        self.generation = 0

    def ask(self) -> Float[np.ndarray, "candidate variant variable"]:
        """The candidates of a generation; they may lie outside of the box, for which `outside` asks its price."""
        own, across = (self.covariance[np.ix_(rows, self.dear)] for rows in (self.dear, self.cheap))
        share = np.linalg.solve(own, across.T).T
        rest = self.covariance[np.ix_(self.cheap, self.cheap)] - share @ across.T
        of_dear, of_cheap = (
            np.linalg.cholesky(part + 1e-10 * np.eye(len(part))) for part in (own, (rest + rest.T) / 2)
        )
        steps = np.empty((POPULATION, self.variants, len(self.mean)))
        dear = self.chance.standard_normal((POPULATION, 1, len(self.dear))) @ of_dear.T
        steps[..., self.dear] = dear
        cheap = self.chance.standard_normal((POPULATION, self.variants, len(self.cheap))) @ of_cheap.T
        steps[..., self.cheap] = dear @ share.T + cheap
        return self.mean + self.spread * steps

    def tell(self, points: Float[np.ndarray, "candidate variable"], values: Float[np.ndarray, " candidate"]) -> None:
        """Move towards the best of a generation, and learn from the way how its variables go together."""
        size, self.generation = len(self.mean), self.generation + 1
        effective = 1 / np.square(self.weights).sum()
        to_path, to_spread_path = 4 / (size + 4), (effective + 2) / (size + effective + 5)
        of_path = 2 / ((size + 1.3) ** 2 + effective)
        of_parents = min(1 - of_path, 2 * (effective - 2 + 1 / effective) / ((size + 2) ** 2 + effective))
        damping = 1 + to_spread_path + 2 * max(0.0, np.sqrt((effective - 1) / (size + 1)) - 1)
        by_chance = np.sqrt(size) * (1 - 1 / (4 * size) + 1 / (21 * size**2))

        steps = (points[np.argsort(values)[:PARENTS]] - self.mean) / self.spread
        step = self.weights @ steps
        self.mean = np.clip(self.mean + self.spread * step, 0, 1)
        lengths, axes = np.linalg.eigh(self.covariance)
        white = axes @ ((axes.T @ step) / np.sqrt(np.maximum(lengths, 1e-12)))
        self.spread_path += -to_spread_path * self.spread_path + _unit(to_spread_path, effective) * white
        length = np.linalg.norm(self.spread_path) / by_chance
        settled = np.sqrt(1 - (1 - to_spread_path) ** (2 * self.generation))
        is_steady = length / settled < 1.4 + 2 / (size + 1)
        self.path += -to_path * self.path + is_steady * _unit(to_path, effective) * step
        self.covariance += of_path * (np.outer(self.path, self.path) - self.covariance)
        self.covariance += of_parents * ((steps.T * self.weights) @ steps - self.covariance)
        self.spread = max(self.spread * np.exp(min(0.3, to_spread_path / damping * (length - 1))), LEAST_SPREAD)


def outside(points: Float[np.ndarray, "*batch variable"]) -> Float[np.ndarray, " *batch"]:
    """The price of lying outside of the unit box."""
    return OUTSIDE * np.square(points - np.clip(points, 0, 1)).sum(axis=-1)


def _unit(share: float, effective: float) -> float:
    """The factor that keeps a path's variance at 1."""
    return np.sqrt(share * (2 - share) * effective)
