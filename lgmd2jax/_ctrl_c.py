"""Ctrl-C while modules load and nothing is begun: the process ends at once, in one line.

An exception would be a traceback there, and extension modules crash on one amid their set-up, or swallow it.
"""

import contextlib
import os
import signal
from collections.abc import Iterator

STOPPED = "stopped; nothing was written"


def end_on_ctrl_c() -> None:
    """From now on; not in a job in the background, which ignores Ctrl-C."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


@contextlib.contextmanager
def ended_by_ctrl_c() -> Iterator[None]:
    """Within the block; afterwards Ctrl-C is an exception again."""
    end_on_ctrl_c()
    try:
        yield
    finally:
        if signal.getsignal(signal.SIGINT) is _end:
            signal.signal(signal.SIGINT, signal.default_int_handler)


def _end(*_: object) -> None:
    os.write(2, f"lgmd2jax: {STOPPED}\n".encode())
    os._exit(130)
