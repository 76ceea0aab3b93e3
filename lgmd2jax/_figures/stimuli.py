"""The figure of a contact sheet."""

import os
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from lgmd2jax._figures.contact_sheet import Card
from lgmd2jax._figures.style import BLUE, GREY, VERMILION, drawn

COLUMNS, ROWS = 3, 8
PAGE = COLUMNS * ROWS  # cards on one sheet
_WIDTH, _HEIGHT, _TOP = 5.4, 1.95, 0.35  # of a card and of the title, inches
_GAP = 0.04  # between frames, as a share of a frame's width


def contact_sheet(path: str | os.PathLike, cards: Sequence[Card], title: str) -> None:
    """One page of up to `PAGE` cards: name, frames at the dots of the time course, and the time course below them."""
    columns = min(COLUMNS, len(cards))
    width, height = _WIDTH * columns, _HEIGHT * -(-len(cards) // columns) + _TOP
    with drawn(path, width, height) as figure:
        figure.set_layout_engine("none")
        figure.suptitle(title, x=0.15 / width, y=1 - 0.12 / height, ha="left", va="top", weight="bold")
        for i, card in enumerate(cards):
            left, top = _WIDTH * (i % columns), height - _TOP - _HEIGHT * (i // columns)

            def panel(x, y, w, h, left=left, top=top):
                """Axes at a place on the card, in inches from its upper left corner."""
                return figure.add_axes(((left + x) / width, (top - y - h) / height, w / width, h / height))

            _strip(panel(0.15, 0.2, _WIDTH - 0.45, 0.75), card)
            _course(panel(0.85, 1.05, _WIDTH - 1.3, 0.5), card)


def _strip(axes: Axes, card: Card) -> None:
    count, rows, cols = card.frames.shape
    gap = max(1, round(_GAP * cols))
    strip = np.full((rows, count * (cols + gap) - gap), np.nan)
    for i, frame in enumerate(card.frames):
        strip[:, i * (cols + gap) : i * (cols + gap) + cols] = frame
    axes.imshow(strip, cmap="gray", vmin=0, vmax=255, interpolation="antialiased")
    axes.set_title(card.name, loc="left", pad=3)
    axes.set_axis_off()


def _course(axes: Axes, card: Card) -> None:
    axes.axvline(0, color=GREY, linewidth=0.8)
    axes.plot(card.time, card.course, color=BLUE, drawstyle="steps-post")
    axes.plot(card.time[card.shown], card.course[card.shown], "o", color=VERMILION, markersize=3.5, clip_on=False)
    axes.set(xlim=(card.time[0], card.time[-1]), ylabel=card.label)
    if len(levels := np.unique(card.course[np.isfinite(card.course)])) <= 2:
        axes.set_yticks(levels)
    axes.annotate("ms", (1, 0), (5, 0), xycoords="axes fraction", textcoords="offset points", va="center", fontsize=8)
