"""What Ctrl-C does: while modules load it ends the process, in one line; later it is an exception that is not lost.

While modules load an exception would be a traceback, and extension modules crash on one amid their set-up, or swallow
it. Python drops one that is raised in a finalizer, or in a callback of the garbage collector, and JAX has such ones.
"""

import _thread
import contextlib
import os
import signal
import sys
import threading
from collections.abc import Iterator
from typing import Any

STOPPED = "stopped; nothing was written"
_LATER = 0.01  # s, when a finalizer or a collection of garbage is over


def end_on_ctrl_c() -> None:
    """From now on; not in a job in the background, which ignores Ctrl-C."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


@contextlib.contextmanager
def ended_by_ctrl_c() -> Iterator[None]:
    """Within the block; afterwards Ctrl-C does what it does by default."""
    end_on_ctrl_c()
    try:
        yield
    finally:
        if signal.getsignal(signal.SIGINT) is _end:
            signal.signal(signal.SIGINT, signal.default_int_handler)


@contextlib.contextmanager
def interrupted_by_ctrl_c() -> Iterator[None]:
    """Within the block a `KeyboardInterrupt` that Python would drop is raised anew."""
    before = sys.unraisablehook

    def hook(dropped: Any) -> None:
        if issubclass(dropped.exc_type, KeyboardInterrupt):
            threading.Timer(_LATER, _thread.interrupt_main).start()
        else:
            before(dropped)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before


def _end(*_: object) -> None:
    os.write(2, f"lgmd2jax: {STOPPED}\n".encode())
    os._exit(130)
