"""The keys of each document, from the JSON Schemas of the package: one page a schema, one table a part."""

import inspect
import json
import re
import tomllib
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import lgmd2jax as lgmd
from docs._make.public_names import links_of, with_references

# What declares the keys of a part in Python: it tells their meaning and their defaults.
_DECLARED_BY: dict[str, tuple[Callable, ...]] = {
    "Eye": (lgmd.Eye,),
    "Solver": (lgmd.fit,),
    "Solver_for_alarms": (lgmd.alarms.fit, lgmd.fit),
    "Recorded_curve": (lgmd.read_target, lgmd.Target),
    "Recorded_spikes": (lgmd.read_spike_trains, lgmd.SpikeTrains),
    "LoomingLaw_target": (lgmd.LoomingLaw, lgmd.Target),
    "Rest_target": (lgmd.Rest, lgmd.Target),
    "Onset_target": (lgmd.Onset, lgmd.Rest, lgmd.Target),
    "Band_target": (lgmd.Band, lgmd.Target),
    "Answer_of_a_model": (lgmd.ModelTarget, lgmd.Target),
    "Camera": (lgmd.stimuli.camera,),
    "Observation": (lgmd.Observation,),
    "Rendering": (lgmd.alarms.Rendering,),
    "Widths": (lgmd.Widths,),
    "Run": (lgmd.fitting.Run,),
    "Uncertainty": (lgmd.fitting.Uncertainty,),
    "Hard": (lgmd.Hard,),
    "fit": (lgmd.Fit,),
    "Soft": (lgmd.Soft,),
    "StraightThrough": (lgmd.StraightThrough,),
    **{name: (getattr(lgmd.stimuli, name),) for name in ("Panorama", "Photograph", "Uniform", "Rolling", "Tabulated")},
    "condition": tuple(lgmd.stimuli.FAMILIES.values()),
    **{
        f"{name}_{part}": (family, lgmd.stimuli.looming)
        for name, family in lgmd.stimuli.FAMILIES.items()
        for part in ("condition", "arguments")
    },
}
_SYMBOLS = {**lgmd.symbols(lgmd.YueRindParameters), **lgmd.symbols(), **lgmd.observation_symbols()}
_WORDS = tomllib.loads((Path(__file__).parent / "keys.toml").read_text(encoding="utf-8"))
_UNITS = ("ms", "degrees", "deg/s", "px", "px/s", "px/s2", "cm", "cm/s", "grey levels", "grey level", "Hz", "(Weber)")
_UNITS += ("(Michelson)", "(factor)", "of the field", "of the light", "cycles per degree", "per image", "1/grey level")
_UNITS += ("frames", "share of the field")


def schema_page(name: str, introduction: str) -> str:
    """The page of a schema of this name, after an introduction with its title."""
    schema = json.loads((files("lgmd2jax") / "schemas" / f"{name}.json").read_text(encoding="utf-8"))
    parts = [introduction.strip()]
    if "properties" in schema:
        parts += ["## The document", _table(name, schema)]
    else:
        parts.append(f"A document is one of: {_type(schema)}.")
    whole = [_part(it) for it in schema.get("oneOf", schema.get("anyOf", ())) if "$ref" in it]
    for part in (*whole, *(part for part in schema["$defs"] if part not in whole)):
        content = schema["$defs"][part]
        parts.append(f"## {_title(part)}")
        parts.append(_table(part, content) if "properties" in content else f"{_type(content)}.")
    return "\n\n".join(parts) + "\n"


def _part(reference: dict[str, Any]) -> str:
    return reference["$ref"].rpartition("/")[2]


def _title(part: str) -> str:
    return part.replace("_", " ")


def _table(part: str, content: dict[str, Any]) -> str:
    rows = ["| key | type | default | unit | meaning |", "|---|---|---|---|---|"]
    known = _meanings(part)
    for key, value in content["properties"].items():
        meaning, unit = _split(value.get("description", ""))
        default, told = known.get(key, ("", ""))
        if key in content.get("required", ()):
            default = "required"
        symbol = _SYMBOLS.get(key)
        if not (meaning or told or part in _DECLARED_BY) and symbol:
            meaning, unit = symbol.meaning, symbol.unit
        told = told or _WORDS.get(f"{part}.{key}") or _WORDS.get(key, "")
        rows.append(f"| `{key}` | {_type(value)} | {default} | {unit} | {_cell(meaning or told)} |")
    return "\n".join(rows)


def _split(description: str) -> tuple[str, str]:
    """The meaning and the unit that a schema's description holds."""
    meaning, _, last = description.rpartition(", ")
    if last in _UNITS:
        return meaning, last.strip("()")
    return description, ""


def _meanings(part: str) -> dict[str, tuple[str, str]]:
    """The default and the meaning of each argument of what declares the part."""
    known: dict[str, tuple[str, str]] = {}
    for declared in _DECLARED_BY.get(part, ()):
        told = _told(inspect.getdoc(declared) or "")
        for name, parameter in inspect.signature(declared).parameters.items():
            default = parameter.default
            shown = "" if default in (inspect.Parameter.empty, None) or "<" in repr(default) else f"`{_toml(default)}`"
            before = known.get(name, ("", ""))
            known[name] = (before[0] or shown, before[1] or told.get(name, ""))
    return known


def _told(docstring: str) -> dict[str, str]:
    """What the list of a docstring tells of each name: an item, or a later sentence of one, begins with names."""
    told = {}
    for item in re.findall(r"^- (`.*(?:\n  .*)*)", docstring, re.M):
        pieces = re.split(r"(?:^|(?<=[.;]) )((?:`\w+`(?:, | or | and |(?=:)))+): ", " ".join(item.split()))
        for names, text in zip(pieces[1::2], pieces[2::2], strict=True):
            told |= dict.fromkeys(re.findall(r"`(\w+)`", names), text.strip().rstrip(".;"))
    return told


def _toml(value) -> str:
    return f"{value:g}" if isinstance(value, (int, float)) and not isinstance(value, bool) else json.dumps(value)


def _type(value: dict[str, Any]) -> str:
    """What a key takes, in words."""
    if "$ref" in value:
        part = _part(value)
        return f"[{_title(part)}](#{part.lower().replace('_', '-')})"
    for word in ("oneOf", "anyOf"):
        if word in value:
            return " or ".join(dict.fromkeys(_type(it) for it in value[word]))
    if "const" in value:
        return f"`{json.dumps(value['const'])}`"
    if "enum" in value:
        return ", ".join(f"`{json.dumps(it)}`" for it in value["enum"])
    kind = value.get("type", "any value")
    if isinstance(kind, list):
        return " or ".join(kind)
    if kind == "array":
        return f"list of {_type(value['items'])}" if "items" in value else "list"
    if kind == "object":
        further = value.get("additionalProperties")
        return f"table of {_type(further)}" if isinstance(further, dict) else "table"
    words = {"integer": "whole number", "string": "text", "boolean": "true, false"}.get(kind, str(kind))
    return words + _range(value)


def _range(value: dict[str, Any]) -> str:
    signs = {"minimum": "≥", "exclusiveMinimum": "&gt;", "maximum": "≤", "exclusiveMaximum": "&lt;"}
    limits = [f"{sign} {value[key]:g}" for key, sign in signs.items() if key in value and abs(value[key]) < 1e8]
    return f" {', '.join(limits)}" if limits else ""


def _cell(text: str) -> str:
    return with_references(text.replace("|", "\\|"), links_of().get)
