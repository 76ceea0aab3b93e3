"""What the columns of a table of trials or spikes are, by their names."""

import re
from collections.abc import Mapping, Sequence

from lgmd2jax._arguments.units import size_of
from lgmd2jax._targets.columns import Columns

# Names in lower case, words joined by "_", without their unit; the likelier before the others.
ROLES: Mapping[str, tuple[str, ...]] = {
    "animal": ("animal", "animal_id", "animal_name", "subject", "subject_id", "locust", "specimen", "cell"),
    "session": ("session", "session_id", "recording", "experiment", "block", "file"),
    "trial": ("trial", "trial_id", "trial_no", "trial_number", "trial_index", "rep", "repeat", "repetition", "sweep"),
    "time": ("spike", "spikes", "spike_time", "spike_times", "time", "times", "t", "timestamp", ""),
    "event": ("collision", "collision_time", "impact", "impact_time", "contact", "event", "event_time", "tc"),
    "l_over_v": ("l_over_v", "lv", "l_v", "loverv", "lover_v", "l_over_abs_v"),
    "start": ("start", "start_time", "begin", "from", "trial_start"),
    "end": ("end", "end_time", "stop", "stop_time", "until", "trial_end"),
}
# What tells stimuli apart besides l/|v|.
CONDITIONS = ("contrast", "polarity", "background", "stimulus", "condition", "shape", "direction")
UNIT_IN_BRACKETS = re.compile(r"\s*[\[(]\s*(\w+)\s*[\])]\s*$")
_PARTS = {
    "l_over_v": re.compile(
        r"(?<![a-z])(?:l[_ ]?over[_ ]?v|l/\|?v\|?|lv)[\s_=:]*(\d+(?:[.p]\d+)?)\s*(?:ms)?(?![a-z0-9])", re.I
    ),
    "trial": re.compile(r"(?<![a-z])(?:trial|repeat|rep|sweep|t|r)[\s_=:#]*(\d+)(?![a-z0-9])", re.I),
    "animal": re.compile(r"(?<![a-z])(?:animal|locust|subject|cell)[\s_=:]*([a-z0-9-]+)(?![a-z0-9])", re.I),
}
_SECONDS = 100.0  # a range of times below is hardly one of ms
_LARGEST_SECONDS = 0.5  # an l/|v| above is one in ms, below one in seconds


def split(name: str) -> tuple[str, str | None]:
    """The name of a column in lower case without its unit of time, and this unit; None where it has none."""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name.strip())
    words = [word for word in re.split(r"[^\w\N{GREEK SMALL LETTER MU}\N{MICRO SIGN}]+|_", spaced) if word]
    unit = words[-1] if words and size_of(words[-1], "ms") and words[-1].lower() not in ("min", "mins") else None
    return "_".join(words[:-1] if unit else words).lower(), unit


def role_of(name: str) -> str | None:
    """What tells the animal, session, trial or condition in the label of a trial; None for another name."""
    base = split(name)[0]
    if base in CONDITIONS:
        return base
    return next((role for role in ("animal", "session", "trial", "l_over_v") if base in ROLES[role]), None)


def label_in(name: str) -> dict[str, str]:
    """Animal, l/|v| and trial in a text such as `A_lv20_trial3`; what has no word of its own by its place."""
    rest, label = UNIT_IN_BRACKETS.sub("", name), {}
    for key, pattern in _PARTS.items():
        if (match := pattern.search(rest)) is not None:
            label[key] = match[1].replace("p", ".") if key == "l_over_v" else match[1]
            rest = rest[: match.start()] + " " + rest[match.end() :]
    words = [word for word in re.split(r"[\s_,;:.()#]+", rest) if word]
    if "trial" not in label and words and words[-1].isdigit():
        label["trial"] = words.pop()
    if "animal" not in label and words:
        label["animal"] = "_".join(words)
    return label


def column_of(role: str, table: Columns, chosen: str | None = None) -> str | None:
    """The column with this role, None where there is none.

    **Arguments:** `chosen`: the column that is named for it, which then must be there.

    **Raises:** `ValueError` for several such columns, and for a chosen one that is not there.
    """
    if chosen is not None:
        table.text(chosen)
        return chosen
    names = [name for name in table.header if name and split(name)[0] in ROLES[role]]
    if len(names) > 1 and role in ("animal", "session"):
        return min(names, key=lambda name: ROLES[role].index(split(name)[0]))
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
        raise ValueError(f"time_unit is {time_unit!r}, but the column is named {name!r}; correct one of them")
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


def speeds_in_ms(name: str, values: Sequence[float]) -> list[float]:
    """l/|v| in ms, which they also are where the name of their column tells no unit.

    **Raises:** `ValueError` for values that are not positive, and for those that look like seconds.
    """
    unit = split(name)[1]
    if min(values) <= 0:
        raise ValueError(f"{name!r} holds {min(values):g}; l/|v| is positive, in ms")
    if unit is None and max(values) <= _LARGEST_SECONDS:
        raise ValueError(
            f"{name!r} holds {min(values):g} to {max(values):g}, as l/|v| in seconds; call it {name}_s, or give ms"
        )
    size = 1.0 if unit is None else size_of(unit, "ms") or 1.0
    return [round(size * value, 9) for value in values]
