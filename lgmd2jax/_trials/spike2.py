"""Trials from the text that Spike2 exports: channels of events, times in seconds.

The form is that which public programs read: INFORMATION, SUMMARY, then for each CHANNEL its kind, comment and title in
quotes, and a row a time; the samples of a waveform follow a line with START. No whole export of Spike2 was found.
"""

import dataclasses
import re
from collections.abc import Sequence
from pathlib import Path

from lgmd2jax._trials.header import ROLES, label_in, split
from lgmd2jax._trials.reading import Draft, Reading, cut, one_of
from lgmd2jax._trials.trial import Condition

_START = re.compile(r'^\s*"?(INFORMATION|SUMMARY|CHANNEL)"?', re.IGNORECASE)
_CHANNEL = re.compile(r'^\s*"CHANNEL"\s*"?(\d+)"?', re.IGNORECASE)
_NUMBER = re.compile(r"^\s*([-+]?\d+(?:[.,]\d+)?(?:e[-+]?\d+)?)(.*)$", re.IGNORECASE)
_QUOTED = re.compile(r'"([^"]*)"')


@dataclasses.dataclass(frozen=True)
class _Channel:
    """A channel of events: its title, times in ms, and the text beside each time."""

    title: str
    times: Sequence[float]
    texts: Sequence[str]


def is_spike2(path: Path) -> bool:
    """Whether a text file begins as an export of Spike2 does."""
    with open(path, encoding="utf-8-sig", errors="replace") as file:
        return _START.match(file.readline()) is not None


def drafts_of_spike2(path: Path, reading: Reading) -> tuple[list[Draft], list[str]]:
    """The trials of a text export: one channel holds the spikes, another one the collisions.

    l/|v| stands in the text of a mark, as `lv20`, or is given.

    **Raises:** `ValueError` for a file without channels of events, and where they must be chosen.
    """
    channels = _channels(path)
    titles = [channel.title for channel in channels]
    named = next((title for title in titles if split(title)[0] in ROLES["event"]), None)
    given = reading.event if isinstance(reading.event, str) else named
    if given is None:
        raise ValueError(
            f"no channel is titled like a collision; name it by event (--event), one of {', '.join(titles)}"
        )
    events = channels.pop(one_of("event", titles, given))
    spikes = channels[one_of("unit", [channel.title for channel in channels], reading.unit)]
    shown = [_condition(text, reading) for text in events.texts]
    return cut(spikes.times, list(zip(events.times, shown, strict=True)), reading, reading.animal or path.stem), []


def _condition(text: str, reading: Reading) -> Condition:
    if isinstance(reading.l_over_v, float):
        return {"l_over_v": reading.l_over_v}
    words = label_in(text)
    return {"l_over_v": float(words["l_over_v"])} if "l_over_v" in words else {}


def _channels(path: Path) -> list[_Channel]:
    """The channels that hold times. The lines before the first time of one are its kind, comment and title."""
    channels: list[tuple[list[str], list[float], list[str]]] = []
    inside = False
    # A waveform may have millions of samples: lines are read one by one, and those are passed over.
    with open(path, encoding="utf-8-sig", errors="replace") as file:
        for line in file:
            if _START.match(line):
                inside = _CHANNEL.match(line) is not None
                if inside:
                    channels.append(([], [], []))
                elif channels:
                    break
            elif inside and line.startswith('"START"'):
                inside = False
            elif inside and line.strip():
                names, times, texts = channels[-1]
                if (number := _NUMBER.match(line)) is not None:
                    times.append(1000 * float(number[1].replace(",", ".")))
                    texts.append(" ".join(_QUOTED.findall(number[2])))
                else:
                    names.extend(_QUOTED.findall(line))
    kept = [_Channel(names[-1], times, texts) for names, times, texts in channels if names and times]
    if not kept:
        raise ValueError(
            "the export holds no channel of events; export the channels of spikes and of collisions as text"
        )
    return kept
