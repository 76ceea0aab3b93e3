"""How fast 100 robots of the arena are simulated; with --train, which settings of their detectors serve best.

python -m benchmarks.arena                    simulated seconds in each second, 100 robots at once, by detector
python -m benchmarks.arena --train            choose the settings of all detectors again, into fits/arena/
python -m benchmarks.arena --train lgmd1      of this one; the others are kept

Settings are chosen on arenas of other seeds than those that `lgmd2jax arena` judges on, with one budget for all: of as
many candidates the one with the fewest collisions per metre, at three quarters of the coverage without a detector.
"""

import argparse
import dataclasses
import json
import os
import time

import jax
import numpy as np

import lgmd2jax as lgmd
from lgmd2jax._compute.xla import set_flags
from lgmd2jax._files.atomic import read_json, replaced
from lgmd2jax._files.catalogue import folder
from lgmd2jax.arena import NetworkDetector, Start, trips
from lgmd2jax.arena._settings import SETTINGS, detectors
from lgmd2jax.arena._training import BUDGET, SPACES, train

_ROBOTS, _SECONDS, _ROUNDS = 100, 20.0, 3


def write_settings(names: list[str]) -> None:
    """Train these detectors; write settings, what candidates there were, and the fitted model as a hand-over file."""
    path = folder("fits") / SETTINGS
    path.parent.mkdir(exist_ok=True)
    for name in names:
        training = train(SPACES[name], progress=True)
        known = read_json(path) if path.exists() else {}
        known[name] = training.plain() | {"budget": dataclasses.asdict(BUDGET)}
        print(name, known[name], flush=True)
        with replaced(path) as temporary:
            text = json.dumps({name: known[name] for name in SPACES if name in known}, indent=1)
            temporary.write_text(text + "\n", encoding="utf-8")
        if name == "lgmd2":
            fitted = SPACES[name].detector(training.settings)
            assert isinstance(fitted, NetworkDetector)
            lgmd.save(fitted.network, path.with_name("model.json"), {"recipe": "python -m benchmarks.arena --train"})


def print_speed() -> None:
    """Simulated seconds of 100 robots in a second of this machine, the median of three rounds."""
    starts = Start.stacked(range(_ROBOTS))
    print(f"{_ROBOTS} robots at once, {_SECONDS:g} s each, on {jax.local_device_count()} cores")
    for name, detector in detectors().items():
        rates, processor = [], []
        for _ in range(_ROUNDS + 1):  # the first one compiles
            begin, used = time.perf_counter(), time.process_time()
            jax.block_until_ready(trips(detector, starts, seconds=_SECONDS))
            rates.append(_SECONDS / (time.perf_counter() - begin))
            processor.append((time.process_time() - used) / _SECONDS)
        print(
            f"{name:12} {np.median(rates[1:]):6.2f} simulated seconds a second; "
            f"{np.median(processor[1:]):.2f} s of processor time for each"
        )


def main() -> None:
    """Measure, or train."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--train", nargs="*", metavar="NAME", help=f"of {', '.join(SPACES)} (default: all)")
    options = parser.parse_args()
    set_flags()
    jax.config.update("jax_num_cpu_devices", os.cpu_count())
    if options.train is not None:
        write_settings(options.train or list(SPACES))
    else:
        print_speed()


if __name__ == "__main__":
    main()
