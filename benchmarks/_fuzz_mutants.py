"""Mutants of documents and of files: with something changed that a user might change, or a disk."""

import copy
import datetime
import json
import math
import re
from typing import Any

import hypothesis.strategies as st

DATES = [datetime.date(2026, 1, 1), datetime.datetime(2026, 1, 1, 9), datetime.time(9)]
EXTREME = [10**400, -(10**30), 1e308, -1e308, 5e-324, math.nan, math.inf, -math.inf, 2**63, 2**31, 0, -1, 256, 0.4]
ODD = [True, False, "", "x", "{", "{eye[fps].__class__}", "../..", "/", ".", "\x00", "a\nb", [], {}, [[]], *DATES]
KEYS = ["name", "kind", "from", "tie", "file", "law", "where", "seed", "eye", "target", "fps", "lag", "version"]
VALUES = st.recursive(
    st.sampled_from([*EXTREME, *ODD]) | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5) | st.sampled_from(KEYS), inner, max_size=3)
    ),
    max_leaves=5,
)


def mutated(data: st.DataObject, document: Any) -> Any:
    """The document with one value, at any depth, replaced, dropped, named otherwise or put elsewhere."""
    document = copy.deepcopy(document)
    place = document
    while True:
        key = data.draw(st.sampled_from(list(place) if isinstance(place, dict) else list(range(len(place)))))
        inner = place[key]
        if not (isinstance(inner, (dict, list)) and inner) or data.draw(st.integers(0, 3)) == 0:
            break
        place = inner
    change = data.draw(st.sampled_from(["replace", "replace", "drop", "rename", "nest", "add"]))
    if change == "replace":
        place[key] = data.draw(VALUES)
    elif change == "nest":
        place[key] = [inner, inner]
    elif change == "add" and isinstance(place, dict):
        place[data.draw(st.text(max_size=5) | st.sampled_from(KEYS))] = data.draw(VALUES)
    else:
        place.pop(key)
        if change == "rename" and isinstance(place, dict):
            place[data.draw(st.text(max_size=5) | st.sampled_from(KEYS))] = inner
    return document


def torn(data: st.DataObject, content: bytes) -> bytes:
    """The bytes with some of them changed, taken out, put in, or cut off at the end; the beginning is hit oftener."""
    content = bytearray(content)
    for _ in range(data.draw(st.integers(1, 4))):
        reach = data.draw(st.sampled_from([64, 512, len(content)]))
        at = data.draw(st.integers(0, max(min(reach, len(content)) - 1, 0)))
        change = data.draw(st.sampled_from(["flip", "flip", "cut", "take", "put"]))
        if change == "flip" and content:
            content[at] = data.draw(st.sampled_from([0, 1, 127, 128, 255]) | st.integers(0, 255))
        elif change == "cut":
            del content[at:]
        elif change == "take":
            del content[at : at + data.draw(st.integers(1, 16))]
        else:
            content[at:at] = data.draw(st.binary(min_size=1, max_size=8))
    return bytes(content)


def toml(value: Any, top: bool = True) -> str:
    """Plain data as TOML, tables within on one line."""
    if isinstance(value, dict):
        pairs = [f"{json.dumps(key)} = {toml(entry, top=False)}" for key, entry in value.items()]
        return "\n".join(pairs) if top else "{ " + ", ".join(pairs) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(toml(entry, top=False) for entry in value) + "]"
    if isinstance(value, (bool, str)):
        return json.dumps(value).replace("\x7f", "\\u007f")
    if isinstance(value, (datetime.date, datetime.time)):
        return value.isoformat()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return re.sub(r"^(-?\d+)e", r"\1.0e", repr(value))
