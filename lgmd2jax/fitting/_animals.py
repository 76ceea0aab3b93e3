"""A fit to each animal by itself."""

import contextlib
import dataclasses
import functools
import multiprocessing
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING, Any, Literal

import jax
from jaxtyping import Array
from tqdm import tqdm

from lgmd2jax._arguments.checked import checked
from lgmd2jax._compute.cluster import checked_client, prepare_worker, running_versions
from lgmd2jax._compute.finished_work import MemoryPart
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._targets.spike_trains import SpikeTrains
from lgmd2jax._targets.target import AnyTarget
from lgmd2jax._targets.weighted import Weighted
from lgmd2jax._types import check_key
from lgmd2jax._words import within
from lgmd2jax.fitting._animal_fits import AnimalFits
from lgmd2jax.fitting._conditions import AnyCondition, pair_of
from lgmd2jax.fitting._fit import fit
from lgmd2jax.fitting._free import Free
from lgmd2jax.fitting._result import Fit
from lgmd2jax.fitting._search.descent import STOPPED
from lgmd2jax.stimuli import Stimulus

if TYPE_CHECKING:
    from distributed import Client

Pair = tuple[Stimulus, list[AnyTarget]]


@checked
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
