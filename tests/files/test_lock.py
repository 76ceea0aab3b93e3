"""One process at a time works on a folder; a lock ends with its holder."""

import os
import socket
import subprocess
import sys

import pytest

from lgmd2jax._files.lock import locked

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="locks are those of POSIX systems")
HOLDER = """
import sys
from lgmd2jax._files.lock import locked
with locked(sys.argv[1]):
    print("ready", flush=True)
    sys.stdin.read()
"""


def test_the_second_is_told_who_is_there_until_the_first_is_killed(tmp_path):
    folder, left_over = tmp_path / "fit", tmp_path / ".fit.0123abcd"
    others = [tmp_path / name for name in (".fit.0123abcd.csv", ".fits.0123abcd", "fit")]
    command = [sys.executable, "-c", HOLDER, str(folder)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "ready\n"
        left_over.mkdir()
        for other in others:
            other.mkdir()
        with (
            pytest.raises(
                ValueError, match=rf"{folder} is in use by process {holder.pid} on {socket.gethostname()} since"
            ),
            locked(folder),
        ):
            pytest.fail("the block ran")
        assert left_over.exists()
        holder.kill()
    assert sorted(os.listdir(tmp_path)) == sorted([".fit.lock", left_over.name, *(other.name for other in others)])
    with locked(folder):
        assert not left_over.exists()
        with pytest.raises(ValueError, match=f"in use by process {os.getpid()} "), locked(folder):
            pytest.fail("the block ran")
    assert sorted(os.listdir(tmp_path)) == sorted(other.name for other in others)


def test_an_error_ends_the_lock(tmp_path):
    with pytest.raises(KeyboardInterrupt), locked(tmp_path / "fit"):
        raise KeyboardInterrupt
    assert not os.listdir(tmp_path)
    with pytest.raises(ValueError, match="does not exist; make it first"), locked(tmp_path / "no" / "fit"):
        pytest.fail("the block ran")
