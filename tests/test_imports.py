"""What importing loads, looked at in processes of their own, where nothing is loaded yet."""

import ast
import importlib
import json
import subprocess
import sys
from pathlib import Path

import jaxtyping
import numpy as np
import pytest

import lgmd2jax as lgmd

HEAVY = ["matplotlib", "skimage", "pandas", "pydantic", "xarray", "scipy.stats"]


def loaded(program, names):
    """Which of the modules a fresh process has loaded after a program."""
    report = f"\nimport json, sys\nprint('', json.dumps([name for name in {names} if name in sys.modules]), sep='\\n')"
    process = subprocess.run([sys.executable, "-c", program + report], capture_output=True, text=True, check=True)
    return json.loads(process.stdout.splitlines()[-1])


def test_importing_loads_nothing_and_sets_nothing():
    program = """
import os, signal, threading, warnings
def state():
    return dict(os.environ), signal.getsignal(signal.SIGINT), threading.active_count(), list(warnings.filters)
before = state()
import lgmd2jax
assert state() == before
"""
    assert loaded(program, ["jax", "numpy", "argparse", "pydantic", "lgmd2jax.fitting", "lgmd2jax.stimuli"]) == []


def test_the_model_the_fit_and_the_stimuli_need_no_figures_photographs_or_tables():
    program = "import lgmd2jax; lgmd2jax.LGMD2; lgmd2jax.fit; lgmd2jax.stimuli.looming"
    assert loaded(program, [*HEAVY, "jax"]) == ["jax"]


def test_a_photograph_loads_what_reads_it():
    program = """
import lgmd2jax as lgmd
eye = lgmd.Eye(6, 8, degrees_per_pixel=4.0, fps=30.0)
lgmd.stimuli.translating(eye, background=lgmd.stimuli.Photograph("camera"), start_ms=0.0, end_ms=40.0)
"""
    assert loaded(program, HEAVY) == ["skimage"]


@pytest.mark.parametrize("package", ["lgmd2jax", "lgmd2jax.alarms", "lgmd2jax.fitting"])
def test_the_stub_names_what_there_is(package):
    """Each name is re-exported as itself, which type checkers ask for, and comes from where the stub says."""
    module = importlib.import_module(package)
    assert module.__file__ is not None
    stub = ast.parse(Path(module.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    for line in stub.body:
        if isinstance(line, ast.AnnAssign):  # of the package itself, as __version__
            assert hasattr(module, ast.unparse(line.target))
            continue
        assert isinstance(line, ast.ImportFrom)
        source = importlib.import_module(f".{line.module or ''}", package) if line.module else module
        for name in line.names:
            assert name.asname == name.name
            assert name.name in dir(module)
            assert getattr(module, name.name) is getattr(source, name.name)


def test_a_name_that_is_none_is_an_attribute_error():
    with pytest.raises(AttributeError, match="LGMD3"):
        lgmd.LGMD3  # pyright: ignore[reportAttributeAccessIssue] # noqa: B018


def test_the_typing_checks_of_this_suite_reach_what_is_loaded_late():
    """The hook of conftest.py decorates a module when it is loaded, which a lazy name does late."""
    with pytest.raises(jaxtyping.TypeCheckError, match="free"):
        lgmd.Free(k=None).slopes(np.zeros((2, 2)))
