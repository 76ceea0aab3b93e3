"""What each command does where it cannot write: on a small disk that is full, and on one that is read-only.

python -m benchmarks.full_disk                        as root on Linux, since it mounts a disk of 1 MB in memory
python -m benchmarks.full_disk --only watch import    some of the commands

Of every command is asked: an exit status of 1, one line that says what the disk refused, no traceback, the earlier
results as they were, and nothing half written. A command that fits into what is left of the disk may succeed; then its
results must be there.
"""

import argparse
import contextlib
import errno
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

from benchmarks._commands import Runner, commands, further_commands
from benchmarks.kills import files_of

_LEFT = (0, 12_000)  # bytes of the disk


@contextlib.contextmanager
def _mounted(disk: Path) -> Iterator[None]:
    disk.mkdir(exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(disk)], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def _fill(disk: Path, left: int) -> None:
    """Write a file that leaves this many bytes of the disk."""
    size = os.statvfs(disk).f_bavail * os.statvfs(disk).f_frsize
    (disk / "filler").write_bytes(bytes(max(0, size - left)))


def _faults(status: int, said: str, before: dict[str, bytes], after: dict[str, bytes]) -> list[str]:
    last = [line for line in said.splitlines() if line.startswith("lgmd2jax: ") and "warning" not in line]
    faults = []
    if status == 0:
        faults += [] if set(after) > set(before) else ["it says that all is well, but nothing was written"]
        videos = [name for name, content in after.items() if name.endswith(".mp4") and not content.startswith(b"[")]
        return [*faults, *(f"{name} cannot be decoded" for name in videos)]
    if status != 1 or len(last) != 1 or "Traceback" in said:
        faults.append(f"exit status {status}, said {said[-200:]!r}")
    elif not any(os.strerror(number) in last[0] for number in (errno.ENOSPC, errno.EROFS)):
        faults.append("it ended for another reason, before it wrote")
    if any(after.get(name) != content for name, content in before.items()):
        faults.append("earlier files are other ones")
    new = [name for name in after if name not in before and not name.startswith("results/sweep.zarr/")]
    unfinished = b'"unfinished": []' not in after.get("results/fit.json", b'"unfinished": []')
    if new and not unfinished:
        faults.append(f"half written: {', '.join(new)}")
    return faults


def main() -> None:
    """Run every command on a full disk and on a read-only one."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", metavar="COMMAND")
    only, bad = parser.parse_args().only, 0
    with tempfile.TemporaryDirectory(prefix="disk-") as name:
        place = Path(name)
        os.environ |= {"XDG_CACHE_HOME": str(place / "cache"), "JAX_PLATFORMS": "cpu"}
        runner, disk, log = Runner(), place / "disk", place / "log.txt"
        for command in (*commands(place), *further_commands(place, runner, log)):
            if only and command.name not in only:
                continue
            for what in (*_LEFT, "read-only"):
                with _mounted(disk):
                    if command.adds_to is not None:
                        (disk / "results").mkdir()
                        for file in ("model.json", "fit.json"):
                            shutil.copy(command.adds_to / file, disk / "results")
                    if isinstance(what, int):
                        _fill(disk, what)
                    else:
                        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
                    before = files_of(disk)
                    status, _ = runner.run(command.at(disk), log, command.stdin)
                    after, said = files_of(disk), log.read_text()
                    hidden = [str(path.relative_to(disk)) for path in disk.rglob(".*")]
                faults = _faults(status, said, before, after)
                kept = [name for name in hidden if not name.endswith(".starts.jsonl")]
                faults += [f"left over: {', '.join(kept)}"] if kept else []
                bad += bool(faults)
                words = what if isinstance(what, str) else f"{what} bytes left"
                line = said.strip().splitlines()[-1] if said.strip() else ""
                print(f"{command.name:18} {words:17} status {status}: {line}", flush=True)
                for fault in faults:
                    print(f"    FAULT: {fault}", flush=True)
    print(f"{bad} with faults")
    raise SystemExit(bool(bad))


if __name__ == "__main__":
    main()
