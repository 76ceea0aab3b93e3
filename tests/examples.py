"""The examples that README.md and the pages in docs/ show, each once, however often it is shown."""

import pathlib
import re

ROOT = pathlib.Path(__file__).parents[1]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
BLOCKS: list[tuple[str, str]] = re.findall(
    r"```(\w+)\n(.*?)```", "\n".join(page.read_text(encoding="utf-8") for page in PAGES), flags=re.DOTALL
)
PROGRAMS = list(dict.fromkeys(block for language, block in BLOCKS if language == "python"))
# Files that a page tells to write: a block whose first line is a comment with the file's name alone.
FILES: dict[str, str] = {
    name[1]: block for _, block in BLOCKS if (name := re.match(r"# (\w+\.toml)\n", block)) is not None
}
_LINES = [line for language, block in BLOCKS if language == "sh" for line in block.splitlines()]
COMMANDS = list(dict.fromkeys(line for line in _LINES if line.startswith("lgmd2jax ")))


def is_slow(example: str) -> bool:
    """Whether it takes a minute or more.

    Whole fits do; tests/fitting/test_fit.py and tests/cli/test_fit.py make small ones. The workers of a cluster start
    slowly; tests/sweep/test_devices.py has one for all its tests.
    """
    if example in COMMANDS:
        return example.split()[1] in ("fit", "characterise") or " --c " in example
    return ".fit(" in example or "Client(" in example
