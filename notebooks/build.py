"""Make the notebooks from their sources and run each from a clean kernel, top to bottom, two at a time.

python -m notebooks.build                     all, written beside their sources
python -m notebooks.build first_fit           only this
python -m notebooks.build --check             all, and none written
python -m notebooks.build --check --tutorial  those that need no clone, by the lgmd2jax that this Python has installed

A source is plain Python in cells: `# %%` begins one of code, `# %% [markdown]` one of text in comments.
"""

import argparse
import re
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import nbformat
from nbclient import NotebookClient

from lgmd2jax._files.atomic import replaced

FOLDER = Path(__file__).parent
TUTORIAL = (
    "first_fit",
    "your_recordings",
    "your_clips",
    "circuit_limits",
    "compare_circuits",
    "fit_to_robot",
    "own_network",
)
PAPER = ("reproduce_paper", "reproduce_recorded", "reproduce_robot")
NAMES = (*TUTORIAL, "after_the_fit", "telling_stimulus", "sweep", "arena", *PAPER)
LIMIT_S, LIMIT_KB = 600, 300
_AT_ONCE = 2  # kernels: most of their time is compilation, which takes one core


def cells(source: str) -> list[nbformat.NotebookNode]:
    """The cells of a source, their ids counted, so that the same run gives the same file."""
    made = []
    for number, (kind, body) in enumerate(re.findall(r"^# %%( \[markdown\])?\n(.*?)(?=^# %%|\Z)", source, re.M | re.S)):
        if kind:
            cell = nbformat.v4.new_markdown_cell(re.sub(r"^# ?", "", body.strip(), flags=re.M))
        else:
            cell = nbformat.v4.new_code_cell(body.strip())
        cell.id = f"cell-{number}"
        made.append(cell)
    return made


def run(name: str) -> nbformat.NotebookNode:
    """The notebook with its outputs, and without what differs from run to run.

    **Raises:** `CellExecutionError` where a cell fails.
    """
    notebook = nbformat.v4.new_notebook(cells=cells((FOLDER / f"{name}.py").read_text(encoding="utf-8")))
    notebook.metadata = {
        "kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"},
        "language_info": {"name": "python"},
    }
    client = NotebookClient(notebook, timeout=LIMIT_S, record_timing=False)
    with tempfile.TemporaryDirectory() as elsewhere:  # the tutorial needs no clone
        client.execute(cwd=elsewhere if name in TUTORIAL else str(FOLDER.parent))
    notebook.metadata["language_info"] = {"name": "python"}
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = [output for output in cell.outputs if not _is_artist(output)]
    return notebook


def _is_artist(output: nbformat.NotebookNode) -> bool:
    """Whether it is what a call of matplotlib returned at the end of a cell, with its address; the figure stays."""
    data = output.get("data", {})
    return set(data) == {"text/plain"} and "matplotlib." in data["text/plain"]


def main() -> int:
    """Run, and write what passed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", nargs="*", help=f"of {', '.join(NAMES)} (default: all)")
    parser.add_argument("--tutorial", action="store_true", help="those that need nothing of a clone")
    parser.add_argument("--check", action="store_true", help="run only; write nothing")
    options = parser.parse_args()
    names = options.name or (TUTORIAL if options.tutorial else NAMES)
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        for name, (text, seconds) in zip(names, pool.map(_timed, names), strict=True):
            size = len(text) / 1000
            print(f"{name}: {seconds:.0f} s, {size:.0f} kB", flush=True)
            if size > LIMIT_KB:
                print(f"{name} has more than {LIMIT_KB} kB; draw less, or at fewer dots per inch", file=sys.stderr)
                return 1
            if not options.check:
                with replaced(FOLDER / f"{name}.ipynb") as path:
                    path.write_text(text, encoding="utf-8")
    return 0


def _timed(name: str) -> tuple[str, float]:
    """The text of a notebook that was run, and the seconds that this took."""
    begin = time.perf_counter()
    return nbformat.writes(run(name)) + "\n", time.perf_counter() - begin


if __name__ == "__main__":
    sys.exit(main())
