"""The tasks of a fit to curves, each about one start: screen the point, descend from it, go on until it converges."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from lgmd2jax._compute.tasks import Result, Stop
from lgmd2jax.fitting._cell_search import search_cell
from lgmd2jax.fitting._problem import Problem
from lgmd2jax.fitting._run import Run
from lgmd2jax.fitting._search.descent import STOPPED
from lgmd2jax.fitting._search.search import Search

_EARLY_STEPS = 20  # at most, at a temperature that is not the last: it only has to lead there
_LAST_STEPS = 5  # times those of all others, for the best run to converge


@dataclasses.dataclass(frozen=True)
class CurveStarts:
    """Each task takes the number of its start, and returns plain data with the `loss` of the model's own thresholds.

    `max_steps`: of the solver at the last temperature.
    """

    search: Search[Problem]
    max_steps: int

    def compile_screening(self) -> None:
        """Screen one start, so that threads find it compiled."""
        self.screen(0, None)

    def screen(self, number: int, stop: Stop) -> Result:
        """The best cell for the pixels of a start."""
        best = search_cell(self.search.space, self.search.points[number], self.search.cells(number))
        return {"z": np.asarray(best.z).tolist(), "loss": float(best.loss)}

    def descend(self, screened: Mapping[int, Result], number: int, stop: Stop) -> Result:
        """The run from the point that the screening left, through all temperatures."""
        start = np.array(screened[number]["z"])
        best = search_cell(self.search.space, start, self.search.cells(number))
        z = tuple(np.asarray(best.z).tolist())
        run = Run(tuple(start.tolist()), z, float(best.loss_before), float(best.loss), np.inf, (), STOPPED)
        return dataclasses.asdict(self._annealed(run, number, self.search.temperatures, self.max_steps, stop))

    def finish(self, descended: Mapping[int, Result], number: int, stop: Stop) -> Result:
        """A run that has not converged, with more steps at the last temperature."""
        run, last = Run.of(descended[number]), self.search.temperatures[-1:]
        return dataclasses.asdict(self._annealed(run, number, last, _LAST_STEPS * self.max_steps, stop))

    def _annealed(self, run: Run, number: int, temperatures: tuple[float, ...], max_steps: int, stop: Stop) -> Run:
        """The run after a descent at each temperature, each followed by a search over the cell."""
        z, loss, best_z = np.array(run.z), run.loss, run.z
        history, soft_loss, result = list(run.history), run.soft_loss, run.result
        for temperature in temperatures:
            if stop is not None and stop.is_set():
                break
            steps = max_steps if temperature == temperatures[-1] else min(max_steps, _EARLY_STEPS)
            descent = self.search.descend(z, temperature, steps, stop)
            history.append(tuple(descent.losses))
            soft_loss, result = descent.losses[-1], descent.result
            best = search_cell(self.search.space, descent.z, self.search.cells(number))
            z = np.asarray(best.z)
            if float(best.loss) < loss:
                loss, best_z = float(best.loss), tuple(z.tolist())
        return Run(run.start, best_z, run.start_loss, loss, soft_loss, tuple(history), result)
