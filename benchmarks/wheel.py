"""Whether an installed wheel works outside of the clone: a smoke test, and the examples of README.md and docs/.

python -m benchmarks.wheel /path/to/the/environment/bin/python

The PYTHON is that of the environment in which the wheel was installed. The examples run in an empty folder, beside a
copy of `stimuli/`. Without `--fits` those that take minutes are left out.
"""

import argparse
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.examples import COMMANDS, FILES, PROGRAMS, ROOT, is_slow

_SMOKE = """
import lgmd2jax as lgmd, pathlib, sys
place = pathlib.Path(lgmd.__file__).resolve()
assert place.is_relative_to(pathlib.Path(sys.prefix).resolve()), f"{place} is not the installed one"
assert lgmd.__version__ == WANTED, lgmd.__version__
assert len(lgmd.load_protocol("looming").conditions) > 3
print(lgmd.load_fit("dcmd").summary())
"""


def main(arguments: list[str] | None = None) -> int:
    """Run all examples and return 1 where one failed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("python", type=Path, help="the Python into whose environment the wheel was installed")
    parser.add_argument("--fits", action="store_true", help="run also what takes minutes")
    options = parser.parse_args(arguments)
    python = str(options.python.absolute())  # not resolved: a virtual environment is known by this path
    smoke = _SMOKE.replace("WANTED", repr(_version()))
    programs = {f"program {i}": program for i, program in enumerate(PROGRAMS) if keep(program, options)}
    lines = {"smoke test": [python, "-c", smoke]}
    lines |= {name: [python, "-c", program] for name, program in programs.items()}
    lines |= {it: [python, "-m", "lgmd2jax.cli", *shlex.split(it)[1:]] for it in COMMANDS if keep(it, options)}
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "stimuli", Path(folder) / "stimuli")
        for name, text in FILES.items():
            (Path(folder) / name).write_text(text)
        for name, line in lines.items():
            began = time.monotonic()
            done = subprocess.run(line, cwd=folder, env=environment, capture_output=True, text=True)
            failed += done.returncode != 0
            print(
                f"{'ok    ' if done.returncode == 0 else 'FAILED'} {time.monotonic() - began:4.0f} s  {name}",
                flush=True,
            )
            if done.returncode:
                print(done.stderr[-2000:])
    print(f"{len(lines) - failed} of {len(lines)} examples ran")
    return int(failed > 0)


def keep(example: str, options: argparse.Namespace) -> bool:
    """Whether an example is run."""
    return options.fits or not is_slow(example)


def _version() -> str:
    for line in (ROOT / "pyproject.toml").read_text(encoding="utf-8").splitlines():
        if line.startswith("version = "):
            return line.split('"')[1]
    raise ValueError("pyproject.toml states no version")


if __name__ == "__main__":
    sys.exit(main())
