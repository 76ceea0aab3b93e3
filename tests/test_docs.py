"""The documentation site: what must stand on its pages. `make docs` builds it."""

import inspect
import json
import re
import tomllib
from collections import Counter
from pathlib import Path

import pytest

from docs._make.privacy import loads_from_elsewhere
from docs._make.public_names import documented, public_names
from docs._make.schema_pages import schema_page

ROOT = Path(__file__).parents[1]


def test_every_public_name_stands_in_the_reference_once():
    public, entries = public_names(), documented()
    assert [entry for entry, count in Counter(entries).items() if count > 1] == []
    assert [entry for entry in entries if entry not in public] == []
    shown = {id(public[entry]) for entry in entries}
    assert [name for name, value in public.items() if id(value) not in shown] == []


def test_help_shows_short_types():
    """A union of arrays and numbers stands behind a name of its own, so that a signature can be read."""
    functions = {name: value for name, value in public_names().items() if inspect.isroutine(value)}
    for name, function in functions.items():
        for argument in inspect.signature(function).parameters.values():
            if argument.annotation is not argument.empty:
                shown = inspect.formatannotation(argument.annotation)
                assert len(shown) <= 160, f"{name}, {argument.name}: {shown}"


@pytest.mark.parametrize("name", ["recipe", "protocol", "labels", "model", "fit"])
def test_the_page_of_a_schema_tells_the_meaning_of_every_key(name):
    page = schema_page(name, "")
    schema = json.loads((ROOT / "lgmd2jax" / "schemas" / f"{name}.json").read_text())
    keys = {key for part in (schema, *schema["$defs"].values()) for key in part.get("properties", ())}
    rows = re.findall(r"^\| `(\w+)` \|.*\| (.*) \|$", page, re.M)
    assert {key for key, _ in rows} == keys
    assert [key for key, meaning in rows if not meaning] == []
    assert re.findall(r"[Aa]s (?:for|of) `[\w.]+`", page) == []  # each is a link to what it names


def test_contributing_lists_every_room():
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    rooms = {room.strip() for line in contracts[0]["layers"] for room in line.split("|")}
    table = re.findall(r"^\| (`.*?) \|", (ROOT / "CONTRIBUTING.md").read_text(), re.M)
    assert Counter(room for cell in table for room in re.findall(r"`(\w+)`", cell)) == Counter(rooms)


@pytest.mark.parametrize(
    "text",
    [
        '<script src="https://cdn.example.org/a.js"></script>',
        "<img alt=x src=//cdn.example.org/a.png>",
        '<link rel="stylesheet" href="https://fonts.example.org/a.css">',
        "<style>@import 'https://fonts.example.org/a.css'</style>",
        "<style>@font-face { src: url(https://fonts.example.org/a.woff2) }</style>",
    ],
)
def test_a_page_that_loads_from_another_host_is_found(text):
    assert loads_from_elsewhere(f'<p><a href="https://example.org">read</a></p>{text}') != []


def test_links_and_own_files_are_not_loaded_from_elsewhere():
    text = '<a href="https://example.org">read</a><script src="../a.js"></script><link rel="stylesheet" href="a.css">'
    assert loads_from_elsewhere(text + '<link rel="canonical" href="https://example.org/">') == []
