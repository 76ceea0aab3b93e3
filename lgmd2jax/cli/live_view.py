"""What a live source shows in the terminal: a picture that is drawn anew, or lines where nobody looks at a screen."""

import contextlib
import math
import sys
from collections import deque
from collections.abc import Iterator
from typing import Any, Protocol

from lgmd2jax.cli.live_tally import Moment, Tally

_BARS = " ▁▂▃▄▅▆▇█"
_HEIGHT = 6  # rows of the trace
_LINE_EVERY_MS, _DRAW_EVERY_MS = 1000.0, 100.0


class View(Protocol):
    """Something that shows each moment."""

    def show(self, moment: Moment, tally: Tally, dropped: int) -> None:
        """Show it, if it is time to."""
        ...


class Lines:
    """A line a second, and one as soon as an alarm begins or ends."""

    def __init__(self):
        self._next, self._raised = 0.0, False

    def show(self, moment: Moment, tally: Tally, dropped: int) -> None:
        """Print the line where it is due."""
        row = moment.row
        if bool(row.collision) == self._raised and row.time_ms < self._next:
            return
        self._next, self._raised = row.time_ms + _LINE_EVERY_MS, bool(row.collision)
        print(_status(moment, tally, dropped), flush=True)


class Screen:
    """The adapted potential of the last seconds as bars, the sides, and the alarm, by rich."""

    def __init__(self, live: Any, levels: tuple[float, ...]):
        self._live, self._levels = live, levels
        self._next, self._raised = 0.0, False
        self._trace: deque[float] = deque(maxlen=max(20, live.console.width - 8))

    def show(self, moment: Moment, tally: Tally, dropped: int) -> None:
        """Draw anew where it is due, and at once where an alarm begins or ends."""
        self._trace.append(moment.row.smp_adapted)
        if bool(moment.row.collision) == self._raised and moment.row.time_ms < self._next:
            return
        self._next, self._raised = moment.row.time_ms + _DRAW_EVERY_MS, bool(moment.row.collision)
        self._live.update(self._panel(moment, tally, dropped), refresh=True)

    def _panel(self, moment: Moment, tally: Tally, dropped: int) -> Any:
        from rich.panel import Panel
        from rich.text import Text

        style = "bold red" if self._raised else "cyan"
        text = Text("\n".join(_bars(self._trace, self._levels)), style=style)
        text.append("\n" + _status(moment, tally, dropped))
        return Panel(text, title="ALARM" if self._raised else "LGMD2", border_style=style)


@contextlib.contextmanager
def view(levels: tuple[float, ...]) -> Iterator[View]:
    """The screen where standard output is a terminal and rich is there, else lines.

    **Arguments:** `levels`: the potentials from which there are spikes.
    """
    if not sys.stdout.isatty():
        yield Lines()
        return
    try:
        from rich.live import Live
    except ImportError:
        print("for a trace in the terminal: pip install 'lgmd2jax[live]'", file=sys.stderr)
        yield Lines()
        return
    with Live(auto_refresh=False, transient=True) as live:
        yield Screen(live, levels)


def _status(moment: Moment, tally: Tally, dropped: int) -> str:
    row = moment.row
    words = [
        f"{row.time_ms / 1000:8.2f} s",
        "ALARM" if row.collision else "     ",
        f"SMP {row.smp_adapted:.3f}",
        f"turn {_turn(moment.mp_sides)}",
        f"{tally.fps:5.1f} fps",
        f"latency {moment.latency_ms:.1f} ms",
        f"dropped {dropped}",
    ]
    if not math.isnan(moment.urgency):
        words.insert(3, f"urgency {moment.urgency:.2f}")
    return "  ".join(words)


def _turn(sides: tuple[float, float, float]) -> str:
    """Away from the side of more potential; nothing where both are alike."""
    left, _, right = (abs(side) for side in sides)
    return "right" if left > right else "left " if right > left else "-    "


def _bars(trace: deque[float], levels: tuple[float, ...]) -> Iterator[str]:
    """The trace between .5 and 1 as bars of eighths, from the top line down; levels are marked at the edge."""
    heights = [round(8 * _HEIGHT * 2 * (value - 0.5)) for value in trace]
    marks = {min(_HEIGHT - 1, int(_HEIGHT * 2 * (level - 0.5))): f"{level:.2f}" for level in levels if level < 1}
    for line in reversed(range(_HEIGHT)):
        bars = "".join(_BARS[min(max(height - 8 * line, 0), 8)] for height in heights)
        yield f"{marks.get(line, ''):4} {bars}"
