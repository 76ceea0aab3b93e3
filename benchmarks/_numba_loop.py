"""The network as one fused loop in numba: the pixels of a frame are passed over once, a row at a time, in float32.

As soon as a row has been advanced, the row above it has all its neighbours and goes through to the sums, while all of
it is still in the nearest cache. No map is kept but what the equations remember.
"""

import os
from concurrent.futures import ThreadPoolExecutor

import numba
import numpy as np

from benchmarks._cell import REST, cell_step
from lgmd2jax.hard import Response

_cell_step = numba.njit(cell_step)
_ZERO, _HALF, _TWO, _EIGHTH = np.float32(0), np.float32(0.5), np.float32(2), np.float32(0.125)


def respond(frames, parameters, fps) -> Response:
    """The response to a clip, on one thread."""
    return Response(*_clip(frames, parameters, np.float32(1000 / fps)))


def respond_batch(clips, parameters, fps) -> list[Response]:
    """The responses to several clips, over all cores; the loop holds no lock while it runs."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(lambda frames: respond(frames, parameters, fps), clips))


@numba.njit(fastmath=True, nogil=True)
def _advance(r, frame, before, on, off, d_on, d_off, sigma1, a):
    """Eqs 1-4 and 13 for a row. Returns the sum of abs(P)."""
    change = _ZERO
    for c in range(frame.shape[1]):
        p = np.float32(frame[r, c]) - np.float32(before[r, c])
        change += abs(p)
        on[r, c] = max(p, _ZERO) + sigma1 * on[r, c]
        off[r, c] = max(-p, _ZERO) + sigma1 * off[r, c]
        d_on[r, c] += a * (on[r, c] - d_on[r, c])
        d_off[r, c] += a * (off[r, c] - d_off[r, c])
    return change


@numba.njit(fastmath=True, nogil=True)
def _columns(r, d_on, d_off, sums_on, sums_off):
    """Down the columns, the [1 2 1] around a row, with the edges repeated beyond the border on all four sides."""
    rows, cols = d_on.shape
    above, below = max(r - 1, 0), min(r + 1, rows - 1)
    for c in range(cols):
        sums_on[c + 1] = d_on[above, c] + _TWO * d_on[r, c] + d_on[below, c]
        sums_off[c + 1] = d_off[above, c] + _TWO * d_off[r, c] + d_off[below, c]
    sums_on[0], sums_on[cols + 1] = sums_on[1], sums_on[cols]
    sums_off[0], sums_off[cols + 1] = sums_off[1], sums_off[cols]


@numba.njit(fastmath=True, nogil=True)
def _potential(r, on, off, d_on, d_off, sums_on, sums_off, v):
    """Eqs 5-11 for a row, from the column sums."""
    potential = _ZERO
    for c in range(on.shape[1]):
        spread_on = _EIGHTH * (sums_on[c] + _TWO * sums_on[c + 1] + sums_on[c + 2]) - _HALF * d_on[r, c]
        spread_off = _EIGHTH * (sums_off[c] + _TWO * sums_off[c + 1] + sums_off[c + 2]) - _HALF * d_off[r, c]
        s_on = on[r, c] - v.w_bias * spread_on
        s_off = spread_off - v.w_bias * off[r, c]
        s = v.theta1 * s_on + v.theta2 * s_off + v.theta3 * s_on * s_off
        potential += s if s >= v.T_s else _ZERO
    return potential


@numba.njit(fastmath=True, nogil=True)
def _clip(frames, v, interval):
    time, rows, cols = frames.shape
    a = interval / (interval + v.tau1)
    on, off = np.zeros((rows, cols), np.float32), np.zeros((rows, cols), np.float32)
    d_on, d_off = np.zeros((rows, cols), np.float32), np.zeros((rows, cols), np.float32)
    sums_on, sums_off = np.empty(cols + 2, np.float32), np.empty(cols + 2, np.float32)
    cell = REST
    mp, ffi, smp, smp_adapted = np.empty(time), np.empty(time), np.empty(time), np.empty(time)
    spikes, collision = np.empty(time, np.int64), np.empty(time, np.bool_)
    for t in range(time):
        frame, before = frames[t], frames[max(t - 1, 0)]
        change = potential = _ZERO
        for r in range(rows + 1):
            if r < rows:
                change += _advance(r, frame, before, on, off, d_on, d_off, v.sigma1, a)
            if r > 0:
                _columns(r - 1, d_on, d_off, sums_on, sums_off)
                potential += _potential(r - 1, on, off, d_on, d_off, sums_on, sums_off, v)
        cell, alarm = _cell_step(cell, float(potential), float(change) / (rows * cols), v, interval, rows * cols)
        mp[t], ffi[t], smp[t], smp_adapted[t] = potential, cell.ffi, cell.smp, cell.smp_adapted
        spikes[t], collision[t] = cell.spikes[3], alarm
    return mp, ffi, smp, smp_adapted, spikes, collision
