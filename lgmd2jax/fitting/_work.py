"""Tasks that do not depend on each other, on all cores, with a memory, a progress bar, and an ear for Ctrl-C."""

import os
import threading
from collections.abc import Callable, Iterable, MutableMapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import Any

import jax
from tqdm import tqdm

Memory = MutableMapping[str, Any]  # of finished tasks, as plain data


class Work:
    """Runs tasks in threads: what XLA computes does not hold Python's lock.

    After Ctrl-C `stop` is set, tasks that have not begun are dropped, and what is done is returned.
    """

    def __init__(self, memory: Memory, progress: bool):
        self.memory, self.stop, self.best = memory, threading.Event(), float("inf")
        self._bar = tqdm(disable=not progress, unit="start", leave=False)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self._bar.close()

    def saw(self, loss: float, start: int) -> None:
        """Show a loss and the start that led to it, where it is the best so far."""
        if loss < self.best:
            self.best = loss
            self._bar.set_postfix_str(f"best loss {loss:.4g} of start {start}")

    def do(
        self, kind: str, task: Callable[[int], dict[str, Any]], numbers: Iterable[int], first: Callable[[], Any] = tuple
    ) -> dict[int, dict[str, Any]]:
        """The results of the tasks by number, in the order of `numbers`. Those in the memory are not done again.

        **Arguments:** `first` is called once, alone, where something is left to be done.
        """
        numbers = list(numbers)
        done = {i: self.memory[f"{kind} {i}"] for i in numbers if f"{kind} {i}" in self.memory}
        self._bar.reset(total=len(numbers))
        self._bar.set_description(kind)
        self._bar.update(len(done))
        wide = jax.config.read("jax_enable_x64")  # a context of the calling thread, perhaps

        def one(number: int) -> dict[str, Any]:
            with jax.enable_x64(wide):
                return task(number)

        def keep(number: int, result: dict[str, Any]) -> None:
            done[number] = result
            if not self.stop.is_set():  # else it may have been cut short
                self.memory[f"{kind} {number}"] = result
            self._bar.update()

        left = [] if self.stop.is_set() else [i for i in numbers if i not in done]
        pool = ThreadPoolExecutor(os.cpu_count())
        futures = {}
        try:
            if left:
                first()
            futures = {pool.submit(one, number): number for number in left}
            for future in as_completed(futures):
                keep(futures[future], future.result())
        except KeyboardInterrupt:
            self.stop.set()
            pool.shutdown(cancel_futures=True)
            for future, number in futures.items():
                if number not in done and future.done() and not future.cancelled():
                    keep(number, future.result())
        finally:
            pool.shutdown(cancel_futures=True)
        return {i: done[i] for i in numbers if i in done}
