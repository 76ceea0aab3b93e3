"""One process at a time works on a folder of results; another one is told who does."""

import contextlib
import datetime
import errno
import json
import os
import shutil
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

from lgmd2jax._files.temporary import lock_beside, temporaries_beside

_WITHOUT_LOCKS = (errno.ENOSYS, errno.ENOTSUP, errno.ENOLCK)  # of a file system


@contextlib.contextmanager
def locked(folder: str | os.PathLike) -> Iterator[None]:
    """Within the block no other process, of this host or of another one, works on the folder, which need not exist.

    The lock is the system's, on a hidden file beside the folder that names its holder. The lock ends with the process,
    however that ends, so that nobody has to remove it. Where the system has no such locks (Windows, some network
    folders) there is none. What killed processes left of the folder is removed.

    **Raises:** `ValueError` that names the holder, and for a place that cannot be written to.
    """
    folder = Path(folder).absolute()
    place = lock_beside(folder)
    if not place.parent.is_dir():
        raise ValueError(f"the folder {place.parent} does not exist; make it first, or write elsewhere")
    if sys.platform == "win32":
        yield
        return
    try:
        descriptor = _taken(place)
    except OSError as error:
        raise ValueError(f"cannot write {folder}: {error.strerror}") from error
    if descriptor is None:
        raise ValueError(f"{folder} is in use by {_holder(place)}; wait for its end, or name another folder")
    try:
        with contextlib.suppress(OSError):  # of a full disk: the lock holds without a name too
            place.write_text(json.dumps(_own_name()), encoding="utf-8")
        for left_over in temporaries_beside(folder):
            shutil.rmtree(left_over, ignore_errors=True)
        yield
    finally:
        place.unlink(missing_ok=True)  # while the lock is held: whoever waits for this file sees that it is gone
        os.close(descriptor)


def _taken(place: Path) -> int | None:
    """The lock's open file, None where another process holds it."""
    while True:
        descriptor = os.open(place, os.O_RDWR | os.O_CREAT, 0o666)
        if not _is_free(descriptor):
            os.close(descriptor)
            return None
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(descriptor), os.stat(place)):
                return descriptor
        os.close(descriptor)  # its last holder has removed it just now


def _is_free(descriptor: int) -> bool:
    import fcntl  # which Windows does not have

    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        if error.errno not in _WITHOUT_LOCKS:
            raise
    return True


def _own_name() -> dict[str, str | int]:
    since = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    return {"pid": os.getpid(), "host": socket.gethostname(), "since": since}


def _holder(place: Path) -> str:
    try:
        holder = json.loads(place.read_text(encoding="utf-8"))
        return f"process {holder['pid']} on {holder['host']} since {holder['since']}"
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"  # which is writing its name just now
