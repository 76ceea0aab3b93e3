"""How much memory `respond` and `watch` take for a clip of an hour, beside that for a tenth of it.

python -m benchmarks.long_clip                 clips of 6 and 60 minutes, 72 x 99 pixels at 30 frames a second
python -m benchmarks.long_clip --minutes 1 6   shorter ones
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks._commands import write_clip

_ROWS, _COLUMNS, _FPS = 72, 99, 30
_LABELS = """
[eye]
rows = 72
cols = 99
degrees_per_pixel = 1
fps = 30
[[clip]]
file = "clip-{minutes}.mp4"
"""
_PROGRAM = """
import resource, sys
from lgmd2jax.cli import main
status = main(sys.argv[1:])
print("peak", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
sys.exit(status)
"""


def peak_megabytes(arguments: list[str]) -> tuple[float, float]:
    """The largest resident memory of a command in MB, and the seconds that it took."""
    began = time.monotonic()
    done = subprocess.run([sys.executable, "-c", _PROGRAM, *arguments], capture_output=True, text=True)
    match = re.search(r"^peak (\d+)$", done.stdout, re.MULTILINE)
    if done.returncode or match is None:
        raise RuntimeError(f"{' '.join(arguments)} ended with {done.returncode}: {done.stderr[-300:]}")
    return int(match[1]) / 1024, time.monotonic() - began


def main() -> None:
    """Print the peak of both commands for each length."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=int, nargs="+", default=[6, 60])
    parser.add_argument("--commands", nargs="+", choices=("respond", "watch"), default=["respond", "watch"])
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="clips-") as name:
        place = Path(name)
        os.environ |= {"XDG_CACHE_HOME": str(place / "cache"), "JAX_PLATFORMS": "cpu"}
        for minutes in options.minutes:
            clip = place / f"clip-{minutes}.mp4"
            write_clip(clip, frames=minutes * 60 * _FPS, size=(_COLUMNS + 1, _ROWS))  # h264 needs even sizes
            (place / f"{minutes}.toml").write_text(_LABELS.format(minutes=minutes), encoding="utf-8")
            commands = {
                "respond": ["respond", str(clip), "--resize", str(_COLUMNS), *_outputs(place)],
                "watch": ["watch", str(place / f"{minutes}.toml")],
            }
            for command in options.commands:
                megabytes, seconds = peak_megabytes(commands[command])
                print(f"{minutes:3} minutes, {command:8}: {megabytes:6.0f} MB at most, {seconds:.0f} s", flush=True)


def _outputs(place: Path) -> list[str]:
    return ["--csv", str(place / "it.csv"), "--figure", str(place / "it.png")]


if __name__ == "__main__":
    main()
