"""How long a sweep takes beside single calls, how much memory, and how it gains from more workers.

python -m benchmarks.sweep

Three tables, each by itself with --only cost, memory or workers. Times are medians over rounds, in which every subject
is called once, so that what disturbs the machine disturbs them all; compilation is apart. XLA compiles as for the
command `lgmd2jax`, unless `XLA_FLAGS` is set.
"""

import argparse
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

import lgmd2jax as lgmd
from benchmarks._timing import time_together
from lgmd2jax._compute.xla import set_flags

EYE = lgmd.Eye(48, 64, degrees_per_pixel=2.0, fps=100.0)
WINDOW = {"start_ms": -900.0, "end_ms": 90.0}  # 100 frames
SIDE = 20
LARGE_SIDE = 64  # some seconds of work, which the default block cuts into 16
TINY = lgmd.Eye(10, 13, degrees_per_pixel=7.0, fps=50.0)


def axes(side: int, shift: float = 0.0) -> dict:
    """Contrast by speed; `shift` changes all values, so that nothing can be remembered."""
    return {"contrast": np.linspace(-0.9, -0.1, side) - shift, "l_over_v": np.linspace(10.0, 80.0, side) + shift}


def cost() -> str:
    """One film's response, 400 conditions with the stimulus given, and 400 with the stimulus rendered."""
    model, film = lgmd.LGMD2(), lgmd.stimuli.looming(EYE, **WINDOW).frames
    still = jnp.asarray(np.random.default_rng(0).normal(0, 2, film.shape), film.dtype)
    noisy = jnp.clip(film + still, 0, 255)  # without noise, maps at rest decay to denormal numbers, which are slow

    def given(eye, *, contrast, l_over_v):
        """The film, dimmer or brighter, so that XLA computes every response anew."""
        time = jnp.asarray(np.arange(len(noisy)) * 10.0)
        return lgmd.Stimulus(noisy * (1 + contrast / 100 + l_over_v / 10000), eye.fps, time)

    forward = jax.jit(lambda model, frames: model(frames, EYE.fps).smp_adapted)
    calls = {
        "one response": lambda: jax.block_until_ready(forward(model, noisy)),
        "a sweep's, film given": lambda: lgmd.sweep(model, given, EYE, **axes(SIDE), block=SIDE**2),
        "a sweep's, rendered": lambda: lgmd.sweep(
            model, lgmd.stimuli.looming, EYE, **axes(SIDE), **WINDOW, block=SIDE**2
        ),
    }
    timings = time_together(calls, rounds=11, at_least=0.3)
    lines = [f"{SIDE} x {SIDE} conditions of 100 frames at 48x64, one core, float32: us a frame, and by one response"]
    for name, timing in timings.items():
        conditions = 1 if name == "one response" else SIDE**2
        ratio = timing.over(timings["one response"]) / conditions
        lines.append(
            f"{name:24}{1e6 * timing.median / conditions / 100:8.1f}{ratio:8.2f}   compile {timing.compile:.1f} s"
        )
    return "\n".join(lines)


def memory() -> str:
    """Peak memory of a process over the number of conditions, stored as they come."""
    lines = ["conditions at 10x13 with 24 frames, stored: peak memory of the process, time"]
    for side in (32, 100, 317):
        began = time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            run = [sys.executable, "-m", "benchmarks.sweep", "--fill", str(Path(folder) / "it.zarr"), str(side)]
            done = subprocess.run(run, check=True, stdout=subprocess.PIPE, text=True)
        lines.append(f"{side**2:8}{int(done.stdout) / 1024:8.0f} MB{time.perf_counter() - began:8.0f} s")
    return "\n".join(lines)


def fill(store: str, side: str) -> int:
    """Make a sweep of side x side conditions; the peak memory of this process in KiB."""
    shown = {"start_ms": -400.0, "end_ms": 60.0, "store": store, "block": 1000, "progress": True}
    lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, TINY, **axes(int(side)), **shown)
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def arithmetic() -> float:
    """Seconds that some plain arithmetic takes here: it shares nothing, so that two at once show two cores."""
    began = time.perf_counter()
    sum(i * i for i in range(2_000_000))
    return time.perf_counter() - began


def workers() -> str:
    """The same sweep on a Dask cluster of one worker process and on one of two, in turns."""
    from distributed import Client, LocalCluster

    def seconds(client, shift):
        began = time.perf_counter()
        lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, EYE, **axes(LARGE_SIDE, shift), **WINDOW, client=client)
        return time.perf_counter() - began

    def processor(client, shift):
        """Seconds of processor time in all workers, which other programs of the machine hardly change."""
        before = sum(client.run(time.process_time).values())
        seconds(client, shift)
        return sum(client.run(time.process_time).values()) - before

    settings = {"threads_per_worker": 1, "dashboard_address": ":0"}
    with (
        LocalCluster(n_workers=1, **settings) as small,
        LocalCluster(n_workers=2, **settings) as large,
        Client(small) as one,
        Client(large) as two,
    ):
        for client in (one, two):
            seconds(client, 0.05)  # every worker compiles
        rounds = [(seconds(one, i / 1000), seconds(two, i / 1000)) for i in range(9)]
        plain = [[max(client.run(arithmetic).values()) for client in (one, two)] for _ in range(9)]
        used = [statistics.median(processor(client, i / 1000) for i in range(10, 15)) for client in (one, two)]
    ratio = statistics.median(first / second for first, second in rounds)
    machine = statistics.median(2 * first / second for first, second in plain)
    least = [min(times) for times in zip(*rounds, strict=True)]
    return (
        f"{LARGE_SIDE} x {LARGE_SIDE} at 48x64 on two workers: {ratio:.2f} times as fast as on one (median of rounds); "
        f"at best {least[0]:.2f} s on one, {least[1]:.2f} s on two: {least[0] / least[1]:.2f} times\n"
        f"plain arithmetic by both workers at once: {machine:.2f} times as fast as by one, so much do two cores give\n"
        f"processor time {used[0]:.2f} s and {used[1]:.2f} s: on idle cores {2 * used[0] / used[1]:.2f} times"
    )


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=("cost", "memory", "workers"), help="one table")
    parser.add_argument("--fill", nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    set_flags()
    if options.fill:
        print(fill(*options.fill))
        return
    for table in (cost, memory, workers):
        if options.only in (None, table.__name__):
            print(table(), end="\n\n")


if __name__ == "__main__":
    main()
