"""How long a frame takes in the exported C, in hard.py, in JAX and in a numba loop, all measured in one run.

python -m benchmarks.c_speed

Every program is called once a round, one after the other, over several rounds, on one core; times are medians of
processor time, so that other work on the machine counts little. Each is checked against `lgmd2jax.hard` first. The film
has whole grey levels, as a camera gives them. The C compiler may use all that this processor has, as numba and XLA do:
fused products, and on x86 whole vector registers, as XLA is told to.
"""

import argparse
import os
import platform
import time

import numpy as np

import lgmd2jax as lgmd
from benchmarks import _library, _peers
from benchmarks._task import FPS, LARGE, PARAMETERS, ROBOT, VALUES, Size, film
from benchmarks._timing import time_together
from lgmd2jax._c.host import compiled
from lgmd2jax._c.source import sources
from lgmd2jax._compute.xla import set_flags
from lgmd2jax._handover.model_file import document
from lgmd2jax.hard import CHANNELS, HardLGMD2, Response, first_difference

FRAMES, ROUNDS = 60, 31
FLAGS = ("-O3", "-march=native", "-ffp-contract=fast")
if platform.machine() == "x86_64":
    FLAGS += ("-mprefer-vector-width=512",)


def programs(size: Size):
    """What each program is called by, and the call."""
    frames = film(size, FRAMES)
    interval = np.full(FRAMES, 1000 / FPS)
    model = lgmd.LGMD2(lgmd.Parameters(**PARAMETERS), eye=lgmd.Eye(*size, 1.0, FPS))
    in_c = compiled(sources(model, document(model)["test_vector"]), *size, FLAGS)
    in_numpy, in_jax = HardLGMD2(PARAMETERS, FPS), _library.forward(lgmd.Hard())
    calls = {"C": lambda: in_c(frames, interval), "hard.py": lambda: in_numpy(frames), "JAX": lambda: in_jax(frames)}
    if loop := _peers.find("_numba_loop"):
        calls["numba loop"] = lambda: loop.respond(frames, VALUES, FPS)
    expected = in_numpy(frames)
    for name, call in calls.items():
        response = call()
        channels = Response(*(np.asarray(getattr(response, channel)) for channel in CHANNELS))
        if (difference := first_difference(channels, expected, tolerance=1e-4)) is not None:
            raise ValueError(f"{name} computes another network: frame and channel {difference} differ; mend it first")
    return calls


def main() -> None:
    """Run the benchmark and print its table."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])
    set_flags()
    print(f"cc {' '.join(FLAGS)}\nsize      program       us a frame   C takes, of its time")
    for size in (ROBOT, LARGE):
        timings = time_together(programs(size), ROUNDS, clock=time.process_time)
        for name, timing in timings.items():
            print(f"{size!s:9} {name:12}{1e6 * timing.median / FRAMES:12.1f}{timings['C'].over(timing):23.2f}")


if __name__ == "__main__":
    main()
