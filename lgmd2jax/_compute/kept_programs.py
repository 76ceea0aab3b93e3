"""Compiled programs are kept on disk between starts of a command, by JAX's persistent compilation cache."""

import contextlib
import hashlib
import os
import platform
import re
import warnings
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

from lgmd2jax._files.cache import cache_folder

LIMIT = 256 << 20  # bytes; the programs of all commands take some 20 MB
_PLACE = "LGMD2JAX_PROGRAMS"  # tells the folder to processes that a command starts
_OFF = {"0", "f", "false", "n", "no", "off"}
_UNREAD, _UNWRITTEN = (f"Error {doing} persistent compilation cache entry" for doing in ("reading", "writing"))


def keep_programs() -> None:
    """Before JAX is imported: ask it to keep what it compiles, unless its user has decided on that.

    The user decides by JAX's own variables, `JAX_COMPILATION_CACHE_DIR` and `JAX_ENABLE_COMPILATION_CACHE`. Processes
    that this one starts share the folder. A program that cannot be read or written is compiled, and nothing is said; a
    spoilt one is written anew.
    """
    if os.environ.get("JAX_ENABLE_COMPILATION_CACHE", "true").lower() in _OFF:
        return
    if (own := os.environ.get("JAX_COMPILATION_CACHE_DIR")) is not None:
        if own and "://" not in own:  # JAX writes to clouds too
            os.environ[_PLACE] = own
        return
    try:
        folder = programs_folder()
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):  # a full disk, a file in its place; no home, of which Path says RuntimeError
        return
    os.environ[_PLACE] = str(folder)
    _drop_oldest(folder.parent)
    os.environ["JAX_COMPILATION_CACHE_DIR"] = str(folder)
    if version("jaxlib").startswith(("0.9.", "0.10.0", "0.10.1")):
        # XLA takes what LLVM tunes for, such as prefer-no-gather, for features that the processor lacks, and prints an
        # error at every program that it reads. The folder is of this kind of processor, so there is none.
        os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    # A command compiles dozens of small programs too, each of which takes longer to compile than to read.
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES", "-1")
    warnings.filterwarnings("always", _UNREAD, UserWarning)
    warnings.filterwarnings("ignore", _UNWRITTEN, UserWarning)
    warnings.showwarning = _removing_unread(folder, warnings.showwarning)
    quiet = [f"ignore:{message}:UserWarning" for message in (_UNREAD, _UNWRITTEN)]  # for processes that this one starts
    os.environ["PYTHONWARNINGS"] = ",".join([*filter(None, [os.environ.get("PYTHONWARNINGS")]), *quiet])


def place_of_programs() -> Path | None:
    """The folder that `keep_programs` chose, in this process or in the one that started it; None: nothing is kept."""
    place = os.environ.get(_PLACE)
    return Path(place) if place else None


def programs_folder() -> Path:
    """The folder for this release of XLA and this kind of processor, for which it compiles."""
    return cache_folder() / "programs" / f"jaxlib-{version('jaxlib')}-{processor()}"


def processor() -> str:
    """A digest of what the processor can do, where Linux tells; else of its name."""
    told = ""
    with contextlib.suppress(OSError), open("/proc/cpuinfo", encoding="utf-8") as file:
        told = next((line for line in file if line.startswith(("flags", "Features"))), "")
    return hashlib.sha256(f"{platform.machine()} {told or platform.processor()}".encode()).hexdigest()[:12]


def _removing_unread(folder: Path, show: Callable[..., None]) -> Callable[..., None]:
    """Shows warnings; of a program that JAX cannot read, which it would never replace, it removes the file instead."""

    def shown(message, *place, **rest):
        unread = re.match(f"{_UNREAD} for '(.*?)'", str(message))
        if unread is None:
            show(message, *place, **rest)
            return
        for path in folder.glob(f"{unread[1]}-*-cache"):  # JAX names the function alone, not which of its programs
            with contextlib.suppress(OSError):  # a folder in its place
                path.unlink(missing_ok=True)

    return shown


def _drop_oldest(folder: Path) -> None:
    """Remove the programs that were used longest ago, of any release, until those that stay keep within the limit."""
    kept = 0
    with contextlib.suppress(OSError):  # another process may be removing them too
        states = [(path, path.stat()) for path in folder.rglob("*-cache")]
        for path, state in sorted(states, key=lambda each: -max(each[1].st_atime, each[1].st_mtime)):
            kept += state.st_size
            if kept > LIMIT:
                path.unlink(missing_ok=True)
