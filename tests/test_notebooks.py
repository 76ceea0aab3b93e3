"""The committed notebooks are what their sources make. `make notebooks` runs them, as does .ci/run."""

import pathlib
import re

import nbformat
import pytest

from notebooks.build import LIMIT_KB, NAMES, TUTORIAL, cells

FOLDER = pathlib.Path(__file__).parents[1] / "notebooks"


@pytest.mark.parametrize("name", NAMES)
def test_the_committed_notebook_is_run_from_its_source(name):
    path = FOLDER / f"{name}.ipynb"
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    wanted = cells((FOLDER / f"{name}.py").read_text(encoding="utf-8"))
    assert [(it.cell_type, it.source) for it in notebook.cells] == [(it.cell_type, it.source) for it in wanted]
    code = [it for it in notebook.cells if it.cell_type == "code"]
    assert [it.execution_count for it in code] == list(range(1, len(code) + 1))
    assert not any(output.output_type == "error" for it in code for output in it.outputs)
    assert path.stat().st_size < 1000 * LIMIT_KB


@pytest.mark.parametrize("name", TUTORIAL)
def test_the_tutorial_needs_nothing_of_a_clone(name):
    """Nothing but what is installed: it runs in an empty folder, and imports no module of the repository."""
    source = (FOLDER / f"{name}.py").read_text(encoding="utf-8")
    assert "lgmd2jax" in source
    assert not re.search(r"^(from|import) (notebooks|benchmarks|tests)\b", source, re.M)


def test_a_source_becomes_cells_in_its_order():
    made = cells("# %% [markdown]\n# # Title\n#\n# Text.\n\n# %%\nx = 1\n\n\n# %%\nprint(x)  # %% not a cell\n")
    assert [(it.cell_type, it.source) for it in made] == [
        ("markdown", "# Title\n\nText."),
        ("code", "x = 1"),
        ("code", "print(x)  # %% not a cell"),
    ]
