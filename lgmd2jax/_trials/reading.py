"""How files of trials are to be read, and the trials that their times make up."""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from lgmd2jax._trials.header import speeds_in_ms
from lgmd2jax._trials.trial import Condition, Trial
from lgmd2jax._trials.trials import Trials

_SHORTEST_MS, _LONGEST_MS = 20.0, 1e6  # of the recorded span about the event: what lies outside has another unit
_REFRACTORY_MS = 0.5  # spikes of a neuron do not follow each other faster
_ENOUGH = 10  # spikes from which the span tells something


@dataclasses.dataclass(frozen=True)
class Reading:
    """What a file may not tell by itself; None: found in the file, or an error that says what is missing.

    **Arguments:**

    - `time_unit`: of spikes and events, `"ms"`, `"s"` or `"us"`.
    - `animal`: the column of the animals, or else the name of the only animal. `trial`, `session`, `time`: columns.
    - `l_over_v`: the column of l/|v|, or else its value in ms.
    - `event`: the column of the event's time (collision), or else its time on the clock of the spikes, in their unit.
    - `conditions`: further columns by which stimuli are told apart.
    - `window`: what was recorded, in ms from the event.
    - `separator`, `decimal`: of a text file.
    - `unit`: of the recorded units (neurons) of a file that holds several, the one to read.
    """

    time_unit: str | None = None
    animal: str | None = None
    session: str | None = None
    trial: str | None = None
    time: str | None = None
    l_over_v: str | float | int | None = None
    event: str | float | int | None = None
    conditions: tuple[str, ...] = ()
    window: tuple[float | int, float | int] | None = None
    separator: str | None = None
    decimal: str | None = None
    unit: str | None = None

    def __post_init__(self):
        for name in ("l_over_v", "event"):
            value = _number_or_name(getattr(self, name))
            if isinstance(value, float) and not math.isfinite(value):
                raise ValueError(f"{name} is {value}; give a finite number, or the name of a column")
            object.__setattr__(self, name, value)
        if isinstance(self.l_over_v, float):
            speeds_in_ms("l_over_v", [self.l_over_v])
        if self.window is not None and not (
            len(self.window) == 2 and all(map(math.isfinite, self.window)) and self.window[0] < self.window[1]
        ):
            raise ValueError(f"window is {self.window}; give its start and end in ms from the event, as (-1000, 500)")


@dataclasses.dataclass
class Draft:
    """A trial while it is read: times in ms, on the clock of the event; its span where the file tells it."""

    animal: str
    session: str
    name: str
    condition: Condition
    spikes: list[float] = dataclasses.field(default_factory=list)
    span: tuple[float, float] | None = None
    place: str = ""


def trials_of(drafts: Sequence[Draft], reading: Reading, remarks: Sequence[str] = ()) -> Trials:
    """The trials, whose times can be those of a neuron.

    **Raises:** `ValueError` for times that look like another unit or clock, and as `Trials`.
    """
    if not drafts:
        raise ValueError("there are no trials")
    remarks = list(remarks)
    spikes = np.concatenate([np.asarray(draft.spikes, float) for draft in drafts])
    if not spikes.size:
        raise ValueError("there is no spike in any trial")
    if not np.isfinite(spikes).all():
        wrong = next(draft for draft in drafts if not np.isfinite(draft.spikes).all())
        raise ValueError(f"animal {wrong.animal}, trial {wrong.name}: a spike time is not finite; leave it out")
    _check_times(drafts, spikes)
    common = reading.window or (min(math.floor(spikes.min()), 0), max(math.ceil(spikes.max()), 0))
    if reading.window is None and any(draft.span is None for draft in drafts):
        remarks.append(
            f"no trial states its start and end: all are taken to last from {common[0]:g} to {common[1]:g} ms, "
            "as their spikes do; else give window (--window)"
        )
    trials, repeated = [], 0
    for draft in drafts:
        start, end = common if draft.span is None or reading.window is not None else draft.span
        own = np.asarray(draft.spikes, float)
        once = np.unique(own)
        repeated += len(own) - len(once)
        own = once
        if reading.window is not None:
            own = own[(own >= start) & (own <= end)]
        trials.append(Trial(draft.animal, draft.name, draft.condition, own, start, end, draft.session))
    if repeated:
        remarks.append(f"{repeated} spikes appear twice in their trial, at the same time; each counts once")
    return Trials(tuple(trials), tuple(remarks))


def _check_times(drafts: Sequence[Draft], spikes: np.ndarray) -> None:
    if spikes.size < _ENOUGH:
        return
    low, high = float(spikes.min()), float(spikes.max())
    where = f"the spikes lie at {low:g} to {high:g} ms from the event"
    intervals = np.concatenate([np.diff(np.sort(np.unique(draft.spikes))) for draft in drafts])
    if high - low < _SHORTEST_MS or (intervals.size and np.median(intervals) < _REFRACTORY_MS):
        raise ValueError(
            f"{where}, as if seconds were taken for ms; give time_unit = 's' (--time-unit s), or correct the header"
        )
    if max(high - low, -low, high) > _LONGEST_MS:
        raise ValueError(
            f"{where}, as if ms were taken for seconds, or as on a session's clock; correct time_unit (--time-unit), "
            "or name the column of the collision by event (--event)"
        )
    if low > 0:
        raise ValueError(
            f"{where}, none of them before, as on the clock of a session or a trial; name the column of the "
            "collision, or give its time, by event (--event)"
        )


def one_of(kind: str, names: Sequence[str], given: str | None) -> int:
    """The place of what is chosen among these, the only one by default.

    **Arguments:** `kind`: what they are, as the argument is called that chooses one.

    **Raises:** `ValueError` for a name that is not there, and where one of several must be named.
    """
    held = ", ".join(map(repr, names))
    if given is not None:
        if given not in names:
            raise ValueError(f"{kind} is {given!r}; choose one of {held}")
        if names.count(given) > 1:
            raise ValueError(f"there are {names.count(given)} {kind}s named {given!r}; give them names of their own")
        return names.index(given)
    if len(names) != 1:
        raise ValueError(
            f"there are {len(names)} {kind}s, {held}; choose one by {kind} (--{kind})"
            if names
            else f"there is no {kind}"
        )
    return 0


def cut(
    spikes_ms: Sequence[float],
    events: Sequence[tuple[float, Condition]],
    reading: Reading,
    animal: str,
    session: str = "",
) -> list[Draft]:
    """The trials of a recording that goes on over several events, numbered from 1.

    **Arguments:** `events`: their times in ms on the clock of the spikes, and what was shown.

    **Raises:** `ValueError` without a window.
    """
    if reading.window is None:
        raise ValueError(
            f"the recording goes on over {len(events)} events; give what belongs to each by window (--window), in ms "
            "from the event, as -1000 500"
        )
    spikes, (start, end) = np.sort(np.asarray(spikes_ms, dtype=float)), reading.window
    drafts = []
    for number, (event, condition) in enumerate(events, start=1):
        own = spikes[(spikes >= event + start) & (spikes <= event + end)] - event
        drafts.append(Draft(animal, session, str(number), condition, own.tolist()))
    return drafts


def _number_or_name(given: str | float | int | None) -> str | float | None:
    if given is None:
        return None
    try:
        return float(given)
    except ValueError:
        return str(given)
