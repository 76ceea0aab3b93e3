"""Whether recorded times can be those of a stimulus: in ms, on its clock."""

import numpy as np
from jaxtyping import Float

_FEWEST = 3  # times from which something can be said
_NARROW = 1 / 200  # of the stimulus: what fills it in seconds spans a thousandth of it in ms
_BURST = 1 / 20  # of the stimulus: within it events must not be closer than they can be
_SPARSE = 0.01  # share of the times within the stimulus
_UNITS = {1e3: "seconds", 1e-3: "microseconds"}


def doubt(times: Float[np.ndarray, " n"], start: float, end: float, closest_ms: float = 0.0) -> str:
    """What speaks against these times, as the end of a sentence about them; empty where nothing does.

    **Arguments:** `start` and `end` of the stimulus; `closest_ms`: how close events can follow each other.
    """
    if times.size < _FEWEST or end <= start:
        return ""
    span, window, inside = float(np.ptp(times)), end - start, share_inside(times, start, end)
    where = f"lie at {times.min():g} to {times.max():g} ms and the stimulus at {start:g} to {end:g} ms"
    too_close = span < _BURST * window and np.median(np.diff(np.sort(times))) < closest_ms
    if inside and (span < _NARROW * window or too_close):
        return f"{where}: they look like seconds; give them in ms"
    if inside >= _SPARSE:
        return ""
    for factor, unit in _UNITS.items():
        if factor * span > _BURST * window and share_inside(factor * times, start, end) > 0.5:
            return f"{where}: they look like {unit}; give them in ms"
    return f"{where}: they look like those of another clock; subtract the time of the event (collision or onset)"


def share_inside(times: Float[np.ndarray, " n"], start: float, end: float) -> float:
    """Of the times, the share within a window."""
    return float(np.mean((times >= start) & (times <= end)))
