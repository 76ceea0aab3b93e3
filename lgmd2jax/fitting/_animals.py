"""One fit an animal, and what holds over animals."""

import contextlib
import csv
import dataclasses
import functools
import importlib
import math
import multiprocessing
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import jax
import numpy as np
from jaxtyping import Array
from tqdm import tqdm

from lgmd2jax._compute.cluster import checked_client, prepare_worker, running_versions
from lgmd2jax._compute.finished_work import MemoryPart
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._reports.digits import measured, plain
from lgmd2jax._reports.section import Section, as_html, as_text
from lgmd2jax._targets.spike_trains import SpikeTrains
from lgmd2jax._targets.target import AnyTarget
from lgmd2jax._targets.weighted import Weighted
from lgmd2jax._types import check_key
from lgmd2jax._words import within
from lgmd2jax.fitting._conditions import AnyCondition, pair_of
from lgmd2jax.fitting._fit import fit
from lgmd2jax.fitting._free import Free
from lgmd2jax.fitting._result import Fit
from lgmd2jax.fitting._search.descent import STOPPED
from lgmd2jax.fitting._uncertainty.random_effects import random_effects
from lgmd2jax.stimuli import Stimulus

if TYPE_CHECKING:
    from distributed import Client

_FEWEST = 2  # animals of which there is a mean and a spread
Pair = tuple[Stimulus, list[AnyTarget]]


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
            rows.append((parameter.name, _unit(parameter.symbol.unit), *cells))
        rows.append(("chi2 a degree of freedom", "", *(_reduced(fit) for fit in self.fits.values())))
        rows.append(("result", "", *(fit.result for fit in self.fits.values())))
        over = tuple(
            (
                parameter.name,
                _unit(parameter.symbol.unit),
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

    def plot(self, path: str | os.PathLike | None = None) -> Any:
        """Draw each parameter of each animal with its interval, and the population's mean and spread.

        **Arguments:** `path`: of a file to write, whose suffix says its format.

        **Returns:** the first panel, a matplotlib `Axes`; its `figure` holds all of them.
        """
        return importlib.import_module("lgmd2jax._figures.animals").plot_animals(self, path)

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


def fit_each(
    model: AbstractNetwork,
    conditions: Sequence[AnyCondition],
    free: Free,
    *,
    key: Array,
    by: Literal["animal"] = "animal",
    processes: int | None = None,
    client: "Client | None" = None,
    progress: bool = False,
    **settings: Any,
) -> AnimalFits:
    """Fit a model to each animal by itself.

    Targets that know their animals, `SpikeTrains`, are divided among these; all others count for every animal. A
    condition in which an animal has no trial is left out of its fit.

    **Arguments:**

    - `model`, `conditions`, `free`, `key` and all further `settings`: as for `fit`; a `memory` holds the work of all
      animals.
    - `by`: what is fitted by itself.
    - `processes`: how many processes of this machine share in the animals; by default this one fits one animal after
      the other, on all its cores. Programs of one's own then need `if __name__ == "__main__":`.
    - `client`: of a Dask cluster, whose workers share in the animals instead.
    - `progress`: show a bar over animals.

    On Ctrl-C the animals that are finished are returned, and the others named in `unfinished`.

    **Raises:** `ValueError`, which names the animal, as `fit`, for targets none of which knows its animals, and for a
    memory where other processes do the fits.
    """
    check_key(key)
    if by != "animal":
        raise ValueError(f"by is {by!r}; give 'animal'")
    if processes is not None and (not isinstance(processes, int) or processes < 1):
        raise ValueError(f"processes is {processes!r}; give a whole number, 1 or more, or None")
    if settings.get("memory") is not None and not (processes is None and client is None):
        raise ValueError("memory is kept by this process, and others do the fits; leave out processes or client")
    animals = {name: [pair for _, pair in pairs] for name, pairs in conditions_by_animal(conditions).items()}
    wide = bool(jax.config.read("jax_enable_x64"))
    task = functools.partial(_fit_animal, model, free, wide, {"key": key, **settings})
    fits: dict[str, Fit] = {}
    with (
        tqdm(total=len(animals), unit="animal", leave=False, disable=not progress) as bar,
        _pool(processes, client) as run,
    ):
        try:
            waiting = {name: run(task, name, pairs) for name, pairs in animals.items()}
            for name, result in waiting.items():
                if (own := result()).result == STOPPED:  # its best so far would pass for the animal's fit
                    raise KeyboardInterrupt
                fits[name] = own
                bar.update()
        except KeyboardInterrupt:
            if not fits:
                raise
    return AnimalFits(fits, tuple(name for name in animals if name not in fits))


def conditions_by_animal(conditions: Sequence[AnyCondition]) -> dict[str, list[tuple[int, Pair]]]:
    """For each animal the numbers of its conditions, and these with the targets that are its own or belong to all.

    **Raises:** `ValueError` where no target knows its animals.
    """
    pairs = [pair_of(condition, number) for number, condition in enumerate(conditions, start=1)]
    names = dict.fromkeys(name for _, targets in pairs for target in targets for name in _animals_of(target) or ())
    if not names:
        raise ValueError("by is 'animal', but no target knows its animals; give spike trains with a column of animals")
    divided: dict[str, list[tuple[int, Pair]]] = {}
    for name in names:
        divided[name] = []
        for number, (stimulus, targets) in enumerate(pairs):
            own = [target for target in targets if _animals_of(target)]
            if own and not any(name in (_animals_of(target) or ()) for target in own):
                continue
            left = [_of_animal(target, name) for target in targets if name in (_animals_of(target) or (name,))]
            divided[name].append((number, (stimulus, left)))
    return divided


def _animals_of(target: AnyTarget) -> Sequence[str] | None:
    if isinstance(target, Weighted):
        return _animals_of(target.target)
    return target.animals if isinstance(target, SpikeTrains) else None


def _of_animal(target: AnyTarget, animal: str) -> AnyTarget:
    if isinstance(target, Weighted):
        return dataclasses.replace(target, target=_of_animal(target.target, animal))
    return target.of(animal) if isinstance(target, SpikeTrains) else target


def _fit_animal(
    model: AbstractNetwork,
    free: Free,
    wide: bool,
    settings: Mapping[str, Any],
    name: str,
    pairs: Sequence[Pair],
) -> Fit:
    memory = settings.get("memory")
    own = {} if memory is None else {"memory": MemoryPart(memory, f"animal {name}")}
    with jax.enable_x64(wide), within(f"animal {name!r}"):
        return fit(model, pairs, free, **{**settings, **own})


Run = Callable[..., Callable[[], Fit]]  # takes a task with its arguments, and gives what waits for its result


@contextlib.contextmanager
def _pool(processes: int | None, client: "Client | None") -> Iterator[Run]:
    """What runs tasks: here, one after the other, in processes of this machine, or on the workers of a cluster."""
    if client is None and processes is None:
        yield functools.partial  # done when waited for
        return
    if client is not None:
        executor: Any = checked_client(client).get_executor(pure=False)
        first = (_on_worker, running_versions())
        stop: dict[str, bool] = {"wait": False}  # which cancels what has not ended
    else:
        cores = max((os.cpu_count() or 1) // (processes or 1), 1)
        context = multiprocessing.get_context("spawn")  # a fork of a process with XLA's threads would hang
        executor = ProcessPoolExecutor(processes, context, _begin_process, (cores,))
        first, stop = (), {"cancel_futures": True}
    try:
        yield lambda *task: executor.submit(*first, *task).result
    finally:
        executor.shutdown(**stop)


def _begin_process(cores: int) -> None:
    """Before a process's first array: no more threads of XLA than its share of the cores."""
    os.environ.setdefault("NPROC", str(cores))


def _on_worker(versions: str, task: Callable[..., Fit], *arguments: Any) -> Fit:
    prepare_worker(versions)
    return task(*arguments)


def _estimate(fit: Fit, i: int) -> str:
    error, name = float(fit.uncertainty.standard_errors[i]), fit.free.names[i]
    text = measured(fit.values[name], error) if fit.uncertainty.determined[i] else f"{plain(fit.values[name])} ?"
    return f"{text} *" if fit.uncertainty.on_bound[i] else text


def _reduced(fit: Fit) -> str:
    return f"{fit.uncertainty.reduced_chi2:.3g}"


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _cells(*numbers: float) -> list[str]:
    return [f"{number:.9g}" if math.isfinite(number) else "" for number in numbers]
