"""A file that cannot be written whole: one line, and the earlier one stays. All commands: benchmarks/full_disk.py."""

import subprocess
import sys

import pytest

from lgmd2jax.cli import main

PROGRAM = """
import resource, sys
from lgmd2jax.cli import main
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))  # a write beyond it fails as on a full disk
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="limits are those of POSIX systems")
def test_an_export_that_does_not_fit_is_one_line_and_leaves_what_is_there(tmp_path, untyped):
    folder = tmp_path / "robot"
    assert main(["export", "preset:balanced", "--python", str(folder)]) == 0
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    command = [sys.executable, "-c", PROGRAM, "export", "preset:lgmd2", "--python", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    assert done.stderr.count("\n") == 1
    assert done.stderr == f"lgmd2jax: {folder}: File too large\n"
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
