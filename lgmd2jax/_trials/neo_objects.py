"""Trials from Neo's blocks and segments, and from the files that Neo reads (the extra `neo`)."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lgmd2jax._arguments.units import has_unit, times
from lgmd2jax._compute.cluster import need
from lgmd2jax._trials.cells import cell_of
from lgmd2jax._trials.header import ROLES, label_in, role_of, speeds_in_ms, split
from lgmd2jax._trials.reading import Draft, Reading, cut, one_of
from lgmd2jax._trials.roles import plain_label, value_of
from lgmd2jax._trials.trial import Condition


def is_neo(source: Any) -> bool:
    """Whether this is a block or a segment of Neo."""
    return hasattr(source, "segments") or hasattr(source, "spiketrains")


def drafts_of_neo_file(path: Path, reading: Reading) -> tuple[list[Draft], list[str]]:
    """The trials of a file of which Neo knows the format.

    **Raises:** `ValueError` without Neo, for a file that it does not read, and as `drafts_of_neo`.
    """
    need("neo", extra="neo")
    import neo.io

    try:
        blocks = neo.io.get_io(str(path)).read(lazy=False)
    except Exception as error:  # each of Neo's readers has errors of its own
        raise ValueError(
            f"neither this program nor Neo reads such a file: {' '.join(str(error).split()):.100}"
        ) from error
    drafts = [draft for block in blocks for draft in drafts_of_neo(block, reading, path.stem)[0]]
    return drafts, []


def drafts_of_neo(source: Any, reading: Reading, animal: str) -> tuple[list[Draft], list[str]]:
    """The trials of a block or a segment, in which a segment is a trial, or its events are.

    What was shown stands in the annotations of the block, the segment, the spike train and the events, or in the labels
    of the events, as `lv20`.

    **Raises:** `ValueError` where the spike train must be chosen, and for several events in a segment without a window.
    """
    segments = list(source.segments) if hasattr(source, "segments") else [source]
    shared = dict(source.annotations) if hasattr(source, "segments") else {}
    drafts: list[Draft] = []
    for number, segment in enumerate(segments, start=1):
        trains = list(segment.spiketrains)
        names = [str(train.name or place) for place, train in enumerate(trains, start=1)]
        train = trains[one_of("unit", names, reading.unit)]
        notes = shared | dict(segment.annotations) | dict(train.annotations)
        label, condition = _label(notes, reading)
        who, session = reading.animal or label.get("animal") or animal, label.get("session", "")
        spikes, events = times(train, "spikes"), _events(segment, reading, condition)
        if len(events) > 1:
            drafts += cut(spikes.tolist(), events, reading, who, session)
            continue
        (event, condition) = events[0] if events else (0.0, condition)
        span = tuple(float(times(edge, "edge")) - event for edge in (train.t_start, train.t_stop))
        name = label.get("trial", str(number))
        drafts.append(Draft(who, session, name, condition, (spikes - event).tolist(), (span[0], span[1])))
    return drafts, []


def _events(segment: Any, reading: Reading, condition: Condition) -> list[tuple[float, Condition]]:
    """Time in ms and condition of each event of the chosen kind."""
    kinds = [event for event in segment.events if len(event)]
    if isinstance(reading.event, str):
        kinds = [kinds[one_of("event", [str(event.name) for event in kinds], reading.event)]]
    else:
        kinds = [event for event in kinds if split(str(event.name))[0] in ROLES["event"]] or kinds
    if not kinds:
        return []
    kind = kinds[one_of("event", [str(event.name) for event in kinds], None)]
    events = []
    for place, time in enumerate(times(kind, "events").tolist()):
        notes = {name: values[place] for name, values in kind.array_annotations.items()}
        own = _label(notes, reading)[1]
        if not own and len(kind.labels) and "l_over_v" in (words := label_in(str(kind.labels[place]))):
            own = {"l_over_v": float(words["l_over_v"])}
        events.append((time, {**condition, **own}))
    return events


def _label(notes: Mapping[str, Any], reading: Reading) -> tuple[dict[str, str], Condition]:
    """Animal, session and trial, and the condition, that annotations tell."""
    label: dict[str, str] = {}
    condition: dict[str, float | str] = {}
    for name, value in notes.items():
        role = "l_over_v" if name == reading.l_over_v else role_of(name)
        if role == "l_over_v":
            condition[role] = speeds_in_ms(name, [float(times(value, name)) if has_unit(value) else float(value)])[0]
        elif role in ("animal", "session", "trial"):
            label[role] = plain_label(cell_of(value))
        elif role is not None or name in reading.conditions:
            condition[name] = value_of(cell_of(value))
    if isinstance(reading.l_over_v, (int, float)):
        condition["l_over_v"] = float(reading.l_over_v)
    return label, condition
