"""Long clips in pieces for a search, so that a minute of silence counts for more than a second of it."""

import dataclasses
from collections.abc import Iterator

import numpy as np

from lgmd2jax._signals import stretches
from lgmd2jax.alarms._clip import LabelledClip, Stretch

_PIECE_MS = 5000.0  # about so long each; a rendered film lasts 5600
_LEAD_MS = 2000.0  # shown before a piece, so that the network comes to the state that it has in the whole clip


def pieces(clip: LabelledClip) -> Iterator[LabelledClip]:
    """The clip in pieces of about equal length, each after the frames that lead to it; no window is cut."""
    since = clip.time - clip.time[0]
    count = max(1, round(since[-1] / _PIECE_MS))
    within_windows = clip.in_windows().any(axis=0)
    cuts = [0]
    for wanted in since[-1] * np.arange(1, count) / count:
        later = np.flatnonzero((since >= wanted) & ~within_windows)
        if len(later) and later[0] > cuts[-1]:
            cuts.append(int(later[0]))
    for start, stop in zip(cuts, [*cuts[1:], len(since)], strict=True):
        lead = int(np.searchsorted(since, since[start] - _LEAD_MS))
        yield _piece(clip, lead, start, stop)


def _piece(clip: LabelledClip, lead: int, start: int, stop: int) -> LabelledClip:
    """The frames from `lead` to `stop`, with the labels from `start` on."""
    shown = slice(lead, stop)
    silent = clip.in_silence() & (np.arange(len(clip.index)) >= start)
    return dataclasses.replace(
        clip,
        frames=clip.frames[shown],
        index=clip.index[shown],
        time=clip.time[shown],
        interval=clip.interval[shown],
        windows=tuple(window for window in clip.windows if clip.index[start] <= window[0] <= clip.index[stop - 1]),
        silent=tuple(_frames(clip, stretch) for stretch in stretches(silent[:stop])),
    )


def _frames(clip: LabelledClip, places: Stretch) -> Stretch:
    first, last = places
    return int(clip.index[first]), int(clip.index[last])
