"""How long the commands take from a shell, the first time and once their programs are compiled.

python -m benchmarks.startup                       each command five times cold and five times warm: half an hour
python -m benchmarks.startup respond "fit twin"    these alone
python -m benchmarks.startup --repeats 1

Each start is a process of its own. A cold one has an empty folder of compiled programs, a warm one what the same
command left there. Printed are medians: seconds of the clock and of the processor, which tell more where the machine
is shared; how many programs XLA was asked for; and the seconds that went into tracing them in Python, into lowering,
and into compiling or reading. Tracing counts a function within a function twice. A warm start reads the library's own
programs whole, with nothing of all this: what is left are small ones, of single operations.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
COMMANDS = {
    "respond": ("respond", "crash.mp4"),
    "watch": ("watch", "crash.toml", "--model", "video"),
    "stimuli": ("stimuli", "looming"),
    "predict": ("predict", "twin", "twin", "-o", "curves.csv"),
    "characterise": ("characterise", "preset:lgmd2"),
    "sweep": ("sweep", "parameters", "-o", "sweep"),
    "looming": ("looming", "synthetic_trials.csv"),
    "import trials": ("import", "synthetic_trials.csv", "-o", "mine", "--fps", "60", "--stop-angle", "80"),
    "export": ("export", "dcmd", "--python", "robot"),
    "arena": ("arena", "--seeds", "1", "--seconds", "5"),
    "fit twin": ("fit", "twin", "-o", "twin"),
    "fit lgmd2": ("fit", "lgmd2", "-o", "lgmd2"),
}
INPUTS = "crash.mp4", "crash.toml", "synthetic_trials.csv"
LISTENER = """
import json, sys
import jax

stages = {"programs": 0}

def listen(event, seconds, **_):
    if name := STAGES.get(event.rpartition("/")[2]):
        stages[name] = stages.get(name, 0) + seconds
        stages["programs"] += name == "compile"

STAGES = {
    "jaxpr_trace_duration": "trace",
    "jaxpr_to_mlir_module_duration": "lower",
    "backend_compile_duration": "compile",
}
jax.monitoring.register_event_duration_secs_listener(listen)
from lgmd2jax.cli import main

status = main(sys.argv[2:])
open(sys.argv[1], "w").write(json.dumps(stages))
sys.exit(status)
"""
LIGHT = {"import": ("-c", "import lgmd2jax"), "help": ("-m", "lgmd2jax.cli", "--help")}
NAMES = ", ".join([*LIGHT, *COMMANDS])


class Start(NamedTuple):
    """One start of a command, in seconds."""

    wall: float
    processor: float
    programs: int
    trace: float
    lower: float
    compile: float


def start(name: str, programs: Path) -> Start:
    """Start a command in a folder of its own, with a folder of compiled programs."""
    with tempfile.TemporaryDirectory() as place:
        for each in INPUTS:
            (Path(place) / each).symlink_to(ROOT / "stimuli" / each)
        told = Path(place) / "stages.json"
        line = LIGHT.get(name) or ("-c", LISTENER, str(told), *COMMANDS[name])
        environment = os.environ | {"JAX_COMPILATION_CACHE_DIR": str(programs)}
        environment |= {"JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0", "PYTHONPATH": str(ROOT)}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)  # users' Python keeps what it compiles too
        before, clock = os.times(), time.monotonic()
        process = subprocess.run([sys.executable, *line], cwd=place, env=environment, capture_output=True, text=True)
        wall, after = time.monotonic() - clock, os.times()
        if process.returncode:
            raise SystemExit(f"{name}: {process.stderr.strip()}")
        processor = after.children_user + after.children_system - before.children_user - before.children_system
        stages = json.loads(told.read_text()) if told.is_file() else {"programs": 0}
        return Start(wall, processor, stages["programs"], *(stages.get(each, 0.0) for each in Start._fields[3:]))


def main() -> None:
    """Start each command, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commands", nargs="*", default=[*LIGHT, *COMMANDS], metavar="COMMAND", help=NAMES)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    if unknown := set(options.commands) - LIGHT.keys() - COMMANDS.keys():
        parser.error(f"no command {', '.join(sorted(unknown))}; there are {NAMES}")
    print(f"{'':16}      wall  processor  programs  trace  lower  compile or read", flush=True)
    for name in options.commands:
        walls = []
        for state in ("cold", "warm"):
            starts = []
            with tempfile.TemporaryDirectory() as kept:
                if state == "warm":
                    start(name, Path(kept))
                for repeat in range(options.repeats):
                    starts.append(start(name, Path(kept) / str(repeat) if state == "cold" else Path(kept)))
            median = Start(*(statistics.median(each) for each in zip(*starts, strict=True)))
            walls.append(median.wall)
            print(
                f"{name:16} {state} {median.wall:5.1f}  {median.processor:9.1f}  {median.programs:8.0f}"
                f"  {median.trace:5.1f}  {median.lower:5.1f}  {median.compile:15.1f}",
                flush=True,
            )
        print(f"{'':16} warm / cold {walls[1] / walls[0]:.2f}", flush=True)


if __name__ == "__main__":
    main()
