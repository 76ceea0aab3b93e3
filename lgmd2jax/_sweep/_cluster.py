"""Blocks on the workers of a Dask cluster: each compiles once, and writes its own chunks of the store."""

import functools
import os
import pickle
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import jax
import numpy as np

from lgmd2jax._sweep._blocks import Plan
from lgmd2jax._sweep._store import Store, need

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
    need("dask", "distributed", extra="cluster")
    from distributed import Client, as_completed
    from distributed.protocol.pickle import dumps

    if not isinstance(client, Client):
        raise ValueError(f"client is {client!r:.60}; give a dask.distributed.Client")
    packed, wide = dumps(plan), bool(jax.config.read("jax_enable_x64"))
    place = None if path is None else os.path.abspath(path)
    futures = client.map(_work, numbers, packed=packed, wide=wide, path=place, pure=False)
    which = {future.key: number for future, number in zip(futures, numbers, strict=True)}
    try:
        for future in as_completed(futures):
            yield which[future.key], future.result()
            future.release()  # the worker forgets what has been taken
    finally:
        client.cancel(futures)


def _work(number: int, packed: bytes, wide: bool, path: str | None) -> Results | None:
    """A block, on a worker."""
    from distributed import get_worker

    # Read by XLA when it starts, with the first array: no more threads than the worker has, else workers of one machine
    # take each other's cores away.
    os.environ.setdefault("NPROC", str(get_worker().state.nthreads))
    with jax.enable_x64(wide):
        plan, store = _unpacked(packed, path)
        found = plan.compute(number)
    if store is None:
        return found
    store.write(number, found)
    return None


@functools.lru_cache(maxsize=2)
def _unpacked(packed: bytes, path: str | None) -> tuple[Plan, Store | None]:
    """Once for all blocks, so that a renderer that travels by value is compiled once too."""
    plan = pickle.loads(packed)
    return plan, None if path is None else Store(plan, path)
