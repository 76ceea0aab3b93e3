"""What the columns of a table of trials or spikes are, by their names."""

import re
from collections.abc import Mapping, Sequence

from lgmd2jax._targets.columns import Columns
from lgmd2jax._targets.units import size_of

# Names in lower case, words joined by "_", without their unit.
ROLES: Mapping[str, frozenset[str]] = {
    "animal": frozenset(("animal", "animal_id", "animal_name", "subject", "subject_id", "locust", "specimen", "cell")),
    "session": frozenset(("session", "session_id", "recording", "experiment", "block", "file")),
    "trial": frozenset(
        ("trial", "trial_id", "trial_no", "trial_number", "trial_index", "rep", "repeat", "repetition", "sweep")
    ),
    "time": frozenset(("spike", "spikes", "spike_time", "spike_times", "time", "times", "t", "timestamp", "")),
    "event": frozenset(
        ("collision", "collision_time", "impact", "impact_time", "contact", "event", "event_time", "tc")
    ),
    "l_over_v": frozenset(("l_over_v", "lv", "l_v", "loverv", "lover_v", "l_over_abs_v")),
    "start": frozenset(("start", "start_time", "begin", "from", "trial_start")),
    "end": frozenset(("end", "end_time", "stop", "stop_time", "until", "trial_end")),
}
# What tells stimuli apart besides l/|v|.
CONDITIONS = frozenset(("contrast", "polarity", "background", "stimulus", "condition", "shape", "direction"))


def split(name: str) -> tuple[str, str | None]:
    """The name of a column in lower case without its unit of time, and this unit; None where it has none."""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name.strip())
    words = [word for word in re.split(r"[^\w\N{GREEK SMALL LETTER MU}\N{MICRO SIGN}]+|_", spaced) if word]
    unit = words[-1] if words and size_of(words[-1], "ms") and words[-1].lower() not in ("min", "mins") else None
    return "_".join(words[:-1] if unit else words).lower(), unit


def column_of(role: str, table: Columns, chosen: str | None = None) -> str | None:
    """The column with this role, None where there is none.

    **Arguments:** `chosen`: the column that is named for it, which then must be there.

    **Raises:** `ValueError` for several such columns, and for a chosen one that is not there.
    """
    if chosen is not None:
        table.text(chosen)
        return chosen
    names = [name for name in table.header if name and split(name)[0] in ROLES[role]]
    if len(names) > 1:
        option = f"{role} (--{role.replace('_', '-')})"
        raise ValueError(f"columns {' and '.join(map(repr, names))} may each be the {role}; name one by {option}")
    return names[0] if names else None


def milliseconds(name: str, values: Sequence[float], time_unit: str | None) -> float:
    """How many ms one of the unit of a column of times is.

    **Arguments:** `values`: of the column, by which a missing unit is guessed, for the message alone.

    **Raises:** `ValueError` for a missing unit, for one that is none of time, and for two that disagree.
    """
    own = split(name)[1]
    size = None if time_unit is None else size_of(time_unit, "ms")
    if time_unit is not None and size is None:
        raise ValueError(f"time_unit is {time_unit!r}; give 'ms', 's' or 'us'")
    if own is not None and size is not None and size_of(own, "ms") != size:
        raise ValueError(f"time_unit is {time_unit!r}, but the column is named {name!r}; mend one of them")
    if own is not None:
        size = size_of(own, "ms")
    if size is None:
        low, high = (min(values), max(values)) if values else (0.0, 0.0)
        likely = "s" if high - low < _SECONDS else "ms"
        raise ValueError(
            f"the times of column {name!r}, {low:g} to {high:g}, have no unit; give it by time_unit = {likely!r} "
            f"(--time-unit {likely}), if that is what they look like, or name the column with it"
        )
    return size


_SECONDS = 100.0  # a range of times below is hardly one of ms
