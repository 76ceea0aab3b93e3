"""Blocks on the workers of a Dask cluster: each compiles once, and writes its own chunks of the store."""

import functools
import os
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import jax
import numpy as np

from lgmd2jax._compute.cluster import checked_client, prepare_worker, running_versions, unpacked
from lgmd2jax._sweep.blocks import Plan
from lgmd2jax._sweep.store import Store

if TYPE_CHECKING:
    from distributed import Client

Results = dict[str, np.ndarray]


def spread(
    plan: Plan, numbers: Sequence[int], client: "Client", path: str | os.PathLike | None
) -> Iterator[tuple[int, Results | None]]:
    """The blocks as they finish, in any order, with their results where no store keeps these.

    Dask computes again what was lost with a worker.

    **Raises:** what a block raises; `ValueError` for what is no client.
    """
    client = checked_client(client)
    from distributed import as_completed
    from distributed.protocol.pickle import dumps

    packed, wide = dumps(plan), bool(jax.config.read("jax_enable_x64"))
    place = None if path is None else os.path.abspath(path)
    futures = client.map(_work, numbers, packed=packed, wide=wide, path=place, versions=running_versions(), pure=False)
    which = {future.key: number for future, number in zip(futures, numbers, strict=True)}
    try:
        for future in as_completed(futures):
            yield which[future.key], future.result()
            future.release()  # the worker forgets what has been taken
    finally:
        client.cancel(futures)


def _work(number: int, packed: bytes, wide: bool, path: str | None, versions: str) -> Results | None:
    """A block, on a worker."""
    prepare_worker(versions)
    with jax.enable_x64(wide):
        plan = unpacked(packed)
        store = None if path is None else _opened(packed, path)
        results = plan.compute(number)
    if store is None:
        return results
    store.write(number, results)
    return None


@functools.lru_cache(maxsize=2)
def _opened(packed: bytes, path: str) -> Store:
    """Once for all blocks of a sweep."""
    return Store(unpacked(packed), path)
