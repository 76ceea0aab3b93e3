"""The public names of the library, and where the pages of the reference treat each."""

import functools
import importlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOMS = ("lgmd2jax", "lgmd2jax.stimuli", "lgmd2jax.alarms", "lgmd2jax.arena", "lgmd2jax.fitting", "lgmd2jax.hard")
_REFERENCE = Path(__file__).parents[1] / "reference"
_AS_FOR = re.compile(r"\b([Aa]s (?:for|of|in|by)) (a call|`[\w.]+`)")


def object_at(start: Any, path: str) -> Any:
    """What stands at a dotted path from a module or class."""
    for name in path.split("."):
        start = getattr(start, name)
    return start


def public_names() -> dict[str, Any]:
    """Each public name with its room, and what it stands for. A room itself is no entry."""
    names = {}
    for room in ROOMS:
        module = importlib.import_module(room)
        for name in _names_of(module):
            value = getattr(module, name)
            if f"{room}.{name}" not in ROOMS:
                names[f"{room}.{name}"] = value
    return names


def _names_of(module) -> list[str]:
    if module.__name__ == "lgmd2jax.hard":  # one file for the robot, without a list of its names
        return [it for it, value in vars(module).items() if it[0] != "_" and _is_defined_in(module, value)]
    if hasattr(module, "__all__"):
        return list(module.__all__)
    source = Path(module.__file__).read_text(encoding="utf-8")
    return [name for name, alias in re.findall(r"(\w+) as (\w+)", source) if name == alias]


def _is_defined_in(module, value) -> bool:
    return getattr(value, "__module__", "") == module.__name__


def documented() -> list[str]:
    """The entries of the reference, in the order of its pages."""
    pages = sorted(_REFERENCE.glob("*.md"))
    return [name for page in pages for name in re.findall(r"^::: (\S+)", page.read_text(encoding="utf-8"), re.M)]


@functools.cache
def links_of() -> dict[str, str]:
    """The entry of each public name: by its whole path, by each end of that, and by its other paths."""
    entries = documented()
    public = public_names()
    links = {}
    for name, value in public.items():
        entry = name if name in entries else next((it for it in entries if public.get(it) is value), None)
        if entry:
            parts = name.split(".")
            for i in range(len(parts)):
                links.setdefault(".".join(parts[i:]), entry)
    return links


def with_references(text: str, entry: Callable[[str], str | None]) -> str:
    """The text, with a link wherever it says "as for" another name. `entry`: of that name in the reference."""

    def reference(match):
        words, name = match.groups()
        found = "lgmd2jax.AbstractNetwork.__call__" if name == "a call" else entry(name.strip("`"))
        return f"{words} [{name}][{found}]" if found else match[0]

    return _AS_FOR.sub(reference, text)
