"""Memory that the gradient needs beside the frames, each case in a process of its own."""

import argparse
import dataclasses
import json
import re
import subprocess
import sys
from pathlib import Path

import jax
import jax.numpy as jnp

from benchmarks._library import exact, loss, parameters, plain
from benchmarks._task import LARGE

RULES = {"exact": exact, "naive": plain}


@dataclasses.dataclass(frozen=True)
class GradientMemory:
    """In bytes: what the compiled program sets aside, and how far the process grew while it ran (None off Linux)."""

    temporary: int
    grown: int | None


def measure(rule: str, time: int) -> GradientMemory:
    """For a film of `time` frames, in a fresh process, so that nothing freed earlier is used again."""
    command = [sys.executable, "-m", "benchmarks._gradient_memory", rule, str(time)]
    return GradientMemory(**json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout))


def _measure_here(rule: str, time: int) -> GradientMemory:
    frames = jax.block_until_ready(jax.jit(_noise, static_argnums=0)(time))
    compiled = jax.jit(jax.grad(loss(RULES[rule]))).lower(parameters(), frames).compile()
    analysis = compiled.memory_analysis()
    assert analysis is not None
    before = _resident("VmRSS")
    if before is not None:
        Path("/proc/self/clear_refs").write_text("5")  # the peak starts anew from here
    jax.block_until_ready(compiled(parameters(), frames))
    peak = _resident("VmHWM")
    return GradientMemory(analysis.temp_size_in_bytes, None if peak is None or before is None else peak - before)


def _noise(time):
    """Frames without a copy of them: a film in NumPy would be there twice."""

    def frame(t):
        return jax.random.uniform(jax.random.key(t), LARGE, jnp.float32, 0, 255)

    return jax.lax.map(frame, jnp.arange(time))


def _resident(field: str) -> int | None:
    try:
        status = Path("/proc/self/status").read_text()
    except OSError:
        return None
    found = re.search(rf"{field}:\s+(\d+) kB", status)
    return int(found[1]) * 1024 if found else None


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rule", choices=RULES)
    parser.add_argument("time", type=int)
    options = parser.parse_args()
    print(json.dumps(dataclasses.asdict(_measure_here(options.rule, options.time))))
