"""What a frame needs of a machine at best: bytes and flops, and how long one core takes for the slower of them."""

import dataclasses

from benchmarks._task import Size

# A pixel of a frame, in one pass: read it and the one before it, uint8, and the four maps, write these; all float32.
BYTES = 1 + 1 + 4 * (4 + 4)
# Additions, multiplications, maxima and comparisons by equation; a lateral spread is separable but for its centre.
FLOPS = sum(
    {
        "P": 1,
        "ON, OFF": 3,
        "residuals": 2 * 2,
        "delays": 2 * 3,
        "lateral spreads": 2 * (3 + 3 + 1),
        "local sums": 2 * 2,
        "S": 6,
        "gate": 2,
        "MP, F": 3,
    }.values()
)


@dataclasses.dataclass(frozen=True)
class Machine:
    """Measured on one thread.

    - `memory`: bytes a second of a triad too large for the caches.
    - `cached`: bytes a second of a triad as large as what the network keeps at this size.
    - `tile`: the same of a triad as large as what a response keeps of a tile.
    - `peak`: flops a second of fused multiply-adds in registers, as numba compiles them.
    """

    memory: float
    cached: dict[Size, float]
    tile: float
    peak: float

    def seconds(self, size: Size) -> float:
        """The shortest time for a frame: by the slower of its traffic and its flops."""
        pixels = size.rows * size.cols
        return max(pixels * BYTES / self.cached[size], pixels * FLOPS / self.peak)
