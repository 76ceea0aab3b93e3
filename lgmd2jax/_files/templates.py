"""Templates beside a module: a file each, whose name without `.jinja` is that of the file that it becomes."""

import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jinja2

_SUFFIX = ".jinja"


def templates(folder: Path) -> dict[str, str]:
    """The texts in a folder, by the path of the file that each becomes."""
    paths = {path.relative_to(folder).as_posix(): path for path in sorted(folder.rglob("*")) if path.is_file()}
    return {name.removesuffix(_SUFFIX): path.read_text(encoding="utf-8") for name, path in paths.items()}


def rendered(text: str, values: Mapping[str, Any]) -> str:
    """The text with these values. One that is missing is a fault of the program."""
    return _environment().from_string(text).render(values)


@functools.cache
def _environment() -> jinja2.Environment:
    return jinja2.Environment(
        undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
