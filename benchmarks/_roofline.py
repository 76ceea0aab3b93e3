"""What one core of this machine could do at best: its bandwidth and its peak, and what a frame needs of them."""

import dataclasses
import time

import numba
import numpy as np

from benchmarks._task import Size

# A pixel of a frame, in one pass: read it, the one before it and the four maps, write the four maps; all float32.
BYTES = 4 * (1 + 1 + 4 + 4)
# Additions, multiplications, maxima and comparisons by equation; a lateral spread is separable.
FLOPS = sum(
    {
        "P": 1,
        "ON, OFF": 3,
        "residuals": 2 * 2,
        "delays": 2 * 3,
        "lateral spreads": 2 * (3 + 3 + 3),
        "local sums": 2 * 2,
        "S": 6,
        "gate": 2,
        "MP, F": 3,
    }.values()
)
_ELSEWHERE = 256 * 2**20  # bytes, beyond every cache


@dataclasses.dataclass(frozen=True)
class Machine:
    """Measured on one thread.

    - `memory`: bytes a second of a triad too large for the caches.
    - `cached`: bytes a second of a triad as large as what the network keeps at this size.
    - `peak`: flops a second of fused multiply-adds in registers, as numba compiles them.
    """

    memory: float
    cached: dict[Size, float]
    peak: float

    def seconds(self, size: Size) -> float:
        """The shortest time for a frame: by the slower of its traffic and its flops."""
        pixels = size.rows * size.cols
        return max(pixels * BYTES / self.cached[size], pixels * FLOPS / self.peak)


def measure(sizes: tuple[Size, ...]) -> Machine:
    """Measure this machine."""
    state = {size: size.rows * size.cols * 4 * 6 for size in sizes}  # four maps and two frames
    return Machine(_bandwidth(_ELSEWHERE), {size: _bandwidth(total) for size, total in state.items()}, _peak())


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
