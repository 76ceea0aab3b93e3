"""Tasks that do not depend on each other, on all cores or on a cluster, with a memory, a bar, and an ear for Ctrl-C."""

import contextlib
import os
import threading
from collections.abc import Callable, Iterable, Iterator, MutableMapping
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from typing import TYPE_CHECKING, Any

import jax
from tqdm import tqdm

from lgmd2jax._compute.cluster import checked_client, prepare_worker, running_versions, unpacked
from lgmd2jax._compute.finished_work import Memory

if TYPE_CHECKING:
    from distributed import Client

Result = dict[str, Any]
_DIGEST = "digest"  # the key of a memory under which it says whose work it keeps
Stop = threading.Event | None  # set when a task is to come to its end; a worker of a cluster is told otherwise
Task = Callable[[int, Stop], Result]


class Work:
    """Runs tasks in threads (what XLA computes does not hold Python's lock), or on the workers of a Dask cluster.

    After Ctrl-C `stop` is set, tasks that have not begun are dropped, and the results that there are are returned. If
    there are none at all, the `KeyboardInterrupt` goes on.

    **Arguments:** `digest`: of all that the results depend on. `total`: how many tasks there are in all, for the one
    bar of all of them.

    **Raises:** `ValueError` for a memory of tasks with another digest, which stays as it was.
    """

    def __init__(
        self,
        memory: Memory,
        progress: bool,
        client: "Client | None" = None,
        *,
        digest: str = "",
        total: int | None = None,
    ):
        if not isinstance(memory, MutableMapping):
            raise ValueError(f"memory is {memory!r:.60}; give a mapping that keeps what is set, such as a dict")
        if memory and memory.get(_DIGEST, "") != digest:
            raise ValueError(
                "memory keeps the work of another fit, of other data, bounds, model or settings, or of another "
                "version; give an empty one"
            )
        self.memory, self.digest, self.stop, self.best = memory, digest, threading.Event(), float("inf")
        self.client = None if client is None else checked_client(client)
        self._results = 0
        self._bar = tqdm(total=total, disable=not progress, unit="start", leave=False)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self._bar.close()

    def do(self, kind: str, task: Task, numbers: Iterable[int], first: Callable[[], Any] = tuple) -> dict[int, Result]:
        """The results of the tasks by number, in the order of `numbers`. Those in the memory are not done again.

        **Arguments:** `task` returns plain data with a `loss`; for a cluster it is to be pickled. `first` compiles: in
        threads it is called once, alone, where something is left to be done.

        **Raises:** `KeyboardInterrupt` where Ctrl-C came before any task was finished.
        """
        numbers = list(numbers)
        results = {i: self.memory[f"{kind} {i}"] for i in numbers if f"{kind} {i}" in self.memory}
        self._results += len(results)
        self._bar.set_description(kind)
        self._bar.update(len(results))

        def keep(number: int, result: Result) -> None:
            results[number] = result
            self._results += 1
            if not self.stop.is_set():  # else it may have been cut short
                if self.digest and _DIGEST not in self.memory:
                    self.memory[_DIGEST] = self.digest
                self.memory[f"{kind} {number}"] = result
            if result["loss"] < self.best:
                self.best = result["loss"]
                self._bar.set_postfix_str(f"best loss {self.best:.4g} of start {number}")
            self._bar.update()

        left = [] if self.stop.is_set() else [i for i in numbers if i not in results]
        futures: dict[Future, int] = {}
        interrupt = None
        with self._pool(task) as submit:
            try:
                if left and self.client is None:
                    first()
                futures = {submit(number): number for number in left}
                for future in as_completed(futures):
                    keep(futures[future], future.result())
            except KeyboardInterrupt as pressed:
                interrupt = pressed
                self.stop.set()
                for future in futures:
                    future.cancel()
        for future, number in futures.items():
            if number not in results and future.done() and not future.cancelled():
                keep(number, future.result())
        if interrupt is not None and not self._results:
            raise interrupt
        return {i: results[i] for i in numbers if i in results}

    @contextlib.contextmanager
    def _pool(self, task: Task) -> Iterator[Callable[[int], Future]]:
        """What runs the task of a number; at the end of the block none is running any more."""
        wide = bool(jax.config.read("jax_enable_x64"))  # a context of the calling thread, perhaps
        if self.client is None:
            pool = ThreadPoolExecutor(os.cpu_count())
            try:
                yield lambda number: pool.submit(_here, task, number, wide, self.stop)
            finally:
                pool.shutdown(cancel_futures=True)
            return
        from distributed.protocol.pickle import dumps

        # A key of its own: under one by content an earlier task's data, being released, would go with this one's.
        packed = self.client.scatter(dumps(task), broadcast=True, hash=False)
        with self.client.get_executor(pure=False) as pool:
            yield lambda number: pool.submit(_there, packed, number, wide, running_versions())


def _here(task: Task, number: int, wide: bool, stop: Stop) -> Result:
    with jax.enable_x64(wide):
        return task(number, stop)


def _there(packed: bytes, number: int, wide: bool, versions: str) -> Result:
    prepare_worker(versions)
    with jax.enable_x64(wide):
        return unpacked(packed)(number, None)
