"""The cell (eqs 12-17) with hard thresholds in plain numbers, for the peers that loop over frames outside of JAX.

It is written from the equations for both the OpenCV peer, which calls it, and the numba peer, which compiles it.
"""

import math
from typing import NamedTuple


class Cell(NamedTuple):
    """What the cell keeps: Fbar, U, U' and the spikes of the last four frames."""

    ffi: float
    smp: float
    smp_adapted: float
    spikes: tuple[int, int, int, int]


REST = Cell(0.0, 0.5, 0.5, (0, 0, 0, 0))


def cell_step(cell: Cell, mp, f, v, interval, pixels):
    """The next state, and whether it is an alarm. `v` has the paper's symbols as attributes."""
    ffi = cell.ffi + interval / (interval + v.tau2) * (f - cell.ffi)
    smp = 1 / (1 + math.exp(-abs(mp) / (pixels * v.k))) if ffi <= v.T_ffi else 0.5
    rise = smp - cell.smp
    kept = v.tau3 / (v.tau3 + interval)
    adapted = max(kept * (cell.smp_adapted + rise) if rise <= v.T_sfa else kept * smp, 0.5)
    spikes = int(adapted >= v.T_sp) + int(adapted > v.T_sp + v.sigma_sp)
    first, second, third, fourth = cell.spikes
    collision = first + second + third + fourth + spikes >= v.N_sp
    return Cell(ffi, smp, adapted, (second, third, fourth, spikes)), collision
