"""What all work on a Dask cluster has in common: its client, and workers that keep to their own cores."""

import functools
import importlib.util
import os
import pickle
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from distributed import Client


def need(*packages: str, extra: str) -> None:
    """Raise `ValueError` that names the extra where a package is not installed."""
    missing = [name for name in packages if importlib.util.find_spec(name) is None]
    if missing:
        raise ValueError(f"this needs {' and '.join(missing)}: pip install 'lgmd2jax[{extra}]'")


def checked_client(client: Any) -> "Client":
    """The client of a cluster.

    **Raises:** `ValueError` for what is no client, and where Dask is not installed.
    """
    need("dask", "distributed", extra="cluster")
    from distributed import Client

    if not isinstance(client, Client):
        raise ValueError(f"client is {client!r:.60}; give a dask.distributed.Client")
    return client


def keep_to_own_cores() -> None:
    """On a worker, before its first array: no more threads of XLA than the worker has.

    Else workers of one machine take each other's cores away.
    """
    from distributed import get_worker

    os.environ.setdefault("NPROC", str(get_worker().state.nthreads))


@functools.lru_cache(maxsize=2)
def unpacked(packed: bytes) -> Any:
    """What travelled by value, once for all tasks, so that what it compiles is compiled once too."""
    return pickle.loads(packed)
