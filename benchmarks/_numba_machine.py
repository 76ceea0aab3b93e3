"""One core of this machine, measured by loops in numba: its bandwidth and its peak."""

import time

import numba
import numpy as np

from benchmarks._roofline import Machine
from benchmarks._task import Size

_ELSEWHERE, _TILE = 256 * 2**20, 2**19  # bytes, beyond every cache, and within that of a core


def measure(sizes: tuple[Size, ...]) -> Machine:
    """Measure this machine."""
    state = {size: size.rows * size.cols * 4 * 6 for size in sizes}  # four maps and two frames
    cached = {size: _bandwidth(total) for size, total in state.items()}
    return Machine(_bandwidth(_ELSEWHERE), cached, _bandwidth(_TILE), _peak())


def _bandwidth(total: int) -> float:
    a, b, c = (np.ones(total // 12, np.float32) for _ in range(3))
    times = max(_ELSEWHERE // total, 1)
    return 12 * len(a) * times / _best(lambda: _triad(a, b, c, np.float32(0.5), times))


def _peak() -> float:
    x, times = np.ones(1024, np.float32), 2000
    return 2 * _CHAIN * len(x) * times / _best(lambda: _multiply_add(x, np.float32(0.5), np.float32(0.25), times))


def _best(call, rounds: int = 7) -> float:
    call()
    durations = []
    for _ in range(rounds):
        began = time.perf_counter()
        call()
        durations.append(time.perf_counter() - began)
    return min(durations)


@numba.njit(fastmath=True)
def _triad(a, b, c, scale, times):
    for _ in range(times):
        for i in range(len(a)):
            a[i] = b[i] + scale * c[i]


_CHAIN = 8


@numba.njit(fastmath={"contract"})
def _multiply_add(x, scale, shift, times):
    for _ in range(times):
        for i in range(len(x)):
            # Written by nesting: a loop here would keep the one around it from becoming vector instructions.
            x[i] = _four(_four(x[i], scale, shift), scale, shift)


@numba.njit(fastmath={"contract"})
def _four(x, scale, shift):
    return (((x * scale + shift) * scale + shift) * scale + shift) * scale + shift
