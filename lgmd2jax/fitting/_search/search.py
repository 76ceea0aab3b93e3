"""What each start of a search needs, whatever is fitted: its point, random cells, and how it is descended."""

import dataclasses
from typing import Generic, TypeVar

import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._compute.tasks import Stop
from lgmd2jax.fitting._search.descent import Descent, Solver, descend
from lgmd2jax.fitting._search.points import seed_of, sobol, starting_points
from lgmd2jax.fitting._search.space import Space
from lgmd2jax.fitting._solver.levenberg_marquardt import BoundedLevenbergMarquardt

AnySpace = TypeVar("AnySpace", bound=Space)
TEMPERATURES = (0.5, 0.2, 0.05)
# Relative to the residuals' norm: what is left to fall is then the square of it, far below what curves can tell.
_RTOL = 3e-3
_ATOL = 1e-8  # for a model that meets its targets exactly; times the scale of the residuals where that is below 1


@dataclasses.dataclass(frozen=True)
class Search(Generic[AnySpace]):
    """The starts of a search on two levels, by number: first the pixels' parameters, then the cell's for each of them.

    - `space`: what is free, and the residuals that a descent makes small.
    - `cell_entries`: the entries of a point that a search over the cell moves.
    - `points`: of the starts; the first is the given one, the others differ from it in what the pixels need.
    - `cell_points`: how many cells each start tries.
    - `seed`: of all random points.
    - `temperatures`: of the descents, falling. `solver`: of each of them.
    """

    space: AnySpace
    cell_entries: tuple[int, ...]
    points: Float[np.ndarray, "start free"]
    cell_points: int
    seed: tuple[int, ...]
    temperatures: tuple[float, ...]
    solver: Solver

    @classmethod
    def of(
        cls,
        space: AnySpace,
        cell_entries: tuple[int, ...],
        start: Float[np.ndarray, " free"],
        *,
        key: Array,
        pixel_points: int,
        cell_points: int,
        temperatures: tuple[float, ...],
        solver: Solver | None = None,
    ) -> "Search[AnySpace]":
        """The search that a key decides, by default with the bounded Levenberg-Marquardt method."""
        seed = seed_of(key)
        points = starting_points(space, start, pixel_points, seed)
        if solver is None:
            solver = BoundedLevenbergMarquardt(_RTOL, _ATOL * min(1.0, space.scale), lower=0.0, upper=1.0)
        return cls(space, cell_entries, points, cell_points, seed, temperatures, solver)

    def cells(self, number: int, *looks: int) -> Float[np.ndarray, "cell entry"]:
        """Random cells of a start, all over the unit box; a further look has others."""
        return sobol(len(self.cell_entries), self.cell_points, (*self.seed, number, *looks))

    def descend(self, z: Float[np.ndarray, " free"], temperature: float, max_steps: int, stop: Stop = None) -> Descent:
        """One descent at one temperature."""
        return descend(self.space, z, temperature, self.solver, max_steps, stop)

    def compile_descent(self) -> None:
        """Take one step, so that threads find it compiled."""
        self.descend(self.points[0], self.temperatures[0], max_steps=1)


def check_counts(counts: dict[str, int], at_least: int) -> None:
    """Raise `ValueError` for the first that is no whole number, or too small."""
    for name, count in counts.items():
        if not isinstance(count, int) or count < at_least:
            raise ValueError(f"{name} is {count!r}; give a whole number, {at_least} or more")
