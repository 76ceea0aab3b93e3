"""The fits of a model to each animal, and what holds over animals."""

import csv
import dataclasses
import functools
import importlib
import math
import os
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from lgmd2jax._arguments.checked import checked
from lgmd2jax._reports.digits import measured, plain
from lgmd2jax._reports.section import Section, as_html, as_text
from lgmd2jax.fitting._cells import unit_cell
from lgmd2jax.fitting._free import Free
from lgmd2jax.fitting._result import Fit
from lgmd2jax.fitting._uncertainty.random_effects import random_effects

_FEWEST = 2  # animals of which there is a mean and a spread


class Population(NamedTuple):
    """A parameter over animals, in its own unit.

    - `mean`, `interval`: of the population, by a random-effects model on the scale of the fit (linear or log).
    - `spread`: standard deviation between animals, beyond the errors of the fits.
    - `inconsistency`: I2, the share of the variance between the estimates that is not their errors'.
    - `animals`: that determine the parameter; the others are left out. Without two of them the numbers are NaN.
    """

    mean: float
    interval: tuple[float, float]
    spread: float
    inconsistency: float
    animals: int


@dataclasses.dataclass(frozen=True)
class AnimalFits:
    """Fits of one model to each animal by itself.

    - `fits`: by the animal's name. `unfinished`: animals that are missing since the fits were stopped.
    """

    fits: Mapping[str, Fit]
    unfinished: tuple[str, ...] = ()

    def __getitem__(self, animal: str) -> Fit:
        return self.fits[animal]

    def __iter__(self) -> Iterator[str]:
        return iter(self.fits)

    def __len__(self):
        return len(self.fits)

    @property
    def free(self) -> Free:
        """What was free in each fit."""
        return next(iter(self.fits.values())).free

    @functools.cached_property
    def population(self) -> dict[str, Population]:
        """Mean and spread of each free parameter over animals."""
        return {name: self._population(i) for i, name in enumerate(self.free.names)}

    def _population(self, i: int) -> Population:
        parameter = self.free.parameters[i]
        known = [fit for fit in self.fits.values() if fit.uncertainty.determined[i] and not fit.uncertainty.on_bound[i]]
        if len(known) < _FEWEST:
            return Population(math.nan, (math.nan, math.nan), math.nan, math.nan, len(known))
        errors = np.array([math.sqrt(fit.uncertainty.covariance_z[i, i]) for fit in known])
        over = random_effects(np.array([fit.z[i] for fit in known]), np.maximum(errors, 1e-9))
        low, high = (float(parameter.value(np.clip(end, 0, 1))) for end in over.interval)
        spread = over.spread * float(parameter.slope(over.mean))
        return Population(float(parameter.value(over.mean)), (low, high), spread, over.inconsistency, len(known))

    def sections(self) -> list[Section]:
        """The report: each animal's parameters, and these over animals."""
        free, numbers = self.free, tuple(f"{animal}|" for animal in self.fits)
        rows = []
        for i, parameter in enumerate(free.parameters):
            cells = [_estimate(fit, i) for fit in self.fits.values()]
            rows.append((parameter.name, unit_cell(parameter.symbol.unit), *cells))
        rows.append(("chi2 a degree of freedom", "", *(_reduced(fit) for fit in self.fits.values())))
        rows.append(("result", "", *(fit.result for fit in self.fits.values())))
        over = tuple(
            (
                parameter.name,
                unit_cell(parameter.symbol.unit),
                plain(each.mean),
                f"{plain(each.interval[0])} .. {plain(each.interval[1])}",
                plain(each.spread),
                f"{each.inconsistency:.0%}",
                f"{each.animals} of {len(self.fits)}",
            )
            for parameter, each in zip(free.parameters, self.population.values(), strict=True)
            if each.animals >= _FEWEST
        )
        columns = ("parameter", "unit", "mean|", "95 % interval|", "spread|", "I2|", "animals|")
        sentences = (
            "Random effects by restricted maximum likelihood with the fits' own errors; intervals of the mean by "
            "Hartung and Knapp. Spread: between animals, beyond these errors; I2: its share of the variance between "
            "estimates. Animals that do not determine a parameter, or have it on a bound, do not count.",
        )
        return [
            *([Section(f"UNFINISHED: without {', '.join(self.unfinished)}")] if self.unfinished else []),
            Section(
                f"{len(self.fits)} animals, a fit each",
                ("parameter", "unit", *numbers),
                tuple(rows),
                ("?: undetermined. *: on a bound.",),
            ),
            *([Section("Over animals", columns, over, sentences)] if over else []),
        ]

    def summary(self) -> str:
        """The report as text."""
        return as_text(self.sections())

    @checked
    def plot(self, path: str | os.PathLike | None = None) -> Any:
        """Draw each parameter of each animal with its interval, and the population's mean and spread.

        **Arguments:** `path`: of a file to write, whose suffix says its format.

        **Returns:** the first panel, a matplotlib `Axes`; its `figure` holds all of them.
        """
        return importlib.import_module("lgmd2jax._figures.animals").plot_animals(self, path)

    @checked
    def write_csv(self, path: str | os.PathLike) -> None:
        """Write a row for each animal and parameter, and for the population: value, standard error, interval."""
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["animal", "parameter", "unit", "value", "standard_error", "low", "high", "spread"])
            for i, parameter in enumerate(self.free.parameters):
                head = parameter.name, parameter.symbol.unit
                for animal, fit in self.fits.items():
                    u = fit.uncertainty
                    known = [u.standard_errors[i], *u.intervals[i]] if u.determined[i] else [math.nan] * 3
                    writer.writerow([animal, *head, *_cells(fit.values[parameter.name], *known, math.nan)])
                each = self.population[parameter.name]
                writer.writerow(["population", *head, *_cells(each.mean, math.nan, *each.interval, each.spread)])

    def __repr__(self):
        return self.summary()

    def _repr_html_(self) -> str:
        return as_html(self.sections())


def _estimate(fit: Fit, i: int) -> str:
    error, name = float(fit.uncertainty.standard_errors[i]), fit.free.names[i]
    text = measured(fit.values[name], error) if fit.uncertainty.determined[i] else f"{plain(fit.values[name])} ?"
    return f"{text} *" if fit.uncertainty.on_bound[i] else text


def _reduced(fit: Fit) -> str:
    return f"{fit.uncertainty.reduced_chi2:.3g}"


def _cells(*numbers: float) -> list[str]:
    return [f"{number:.9g}" if math.isfinite(number) else "" for number in numbers]
