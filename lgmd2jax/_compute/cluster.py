"""What all work on a Dask cluster has in common: its client, and workers that run what the client runs."""

import functools
import hashlib
import importlib.util
import os
import pickle
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from distributed import Client

_DECIDING = ("jax", "jaxlib", "equinox", "optimistix", "lineax", "numpy")


def need(*packages: str, extra: str) -> None:
    """Raise `ValueError` that names the extra where a package is not installed."""
    missing = [name for name in packages if not is_installed(name)]
    if missing:
        raise ValueError(f"this needs {' and '.join(missing)}: pip install 'lgmd2jax[{extra}]'")


def is_installed(package: str) -> bool:
    """Whether a package can be imported. It is not imported for that."""
    try:
        return importlib.util.find_spec(package) is not None
    except ValueError:  # another thread is importing it just now
        return True


def checked_client(client: Any) -> "Client":
    """The client of a cluster whose workers run the same versions as this process.

    **Raises:** `ValueError` for what is no client, where Dask is not installed, and for a worker of another version.
    """
    need("dask", "distributed", extra="cluster")
    from distributed import Client

    if not isinstance(client, Client):
        raise ValueError(f"client is {client!r:.60}; give a dask.distributed.Client")
    answers: Any = client.run(running_versions, on_error="return")
    for worker, versions in answers.items():
        _check_versions(worker, str(versions), running_versions())  # of a worker without this function an exception
    return client


@functools.cache
def running_versions() -> str:
    """What decides the numbers that this process computes: lgmd2jax to the letter of its source, and what it calls."""
    package = Path(__file__).parents[1]
    source = hashlib.sha256(b"".join(path.read_bytes() for path in sorted(package.rglob("*.py")))).hexdigest()[:12]
    others = ", ".join(f"{name} {version(name)}" for name in _DECIDING)
    return f"lgmd2jax {version('lgmd2jax')} (source {source}) with {others}"


def _check_versions(worker: str, worker_runs: str, client_runs: str) -> None:
    if worker_runs != client_runs:
        raise ValueError(
            f"the worker {worker} runs {worker_runs}, this process {client_runs}; install the same version for both"
        )


def prepare_worker(client_runs: str) -> None:
    """On a worker, before its first array: no more threads of XLA than the worker has.

    Else workers of one machine take each other's cores away.

    **Arguments:** `client_runs`: the versions of the client, since workers may join after its check.

    **Raises:** `ValueError` where this worker runs others.
    """
    from distributed import get_worker

    _check_versions(get_worker().address, running_versions(), client_runs)
    os.environ.setdefault("NPROC", str(get_worker().state.nthreads))


@functools.lru_cache(maxsize=2)
def unpacked(packed: bytes) -> Any:
    """What travelled by value, once for all tasks, so that what it compiles is compiled once too."""
    return pickle.loads(packed)
