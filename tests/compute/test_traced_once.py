"""Programs that are traced once for all starts: the next start calls no Python function, and answers the same."""

import json
import os
import subprocess
import sys

import pytest

PROGRAM = """
from lgmd2jax._compute.kept_programs import keep_programs
keep_programs()
import json
import jax, jax.numpy as jnp, numpy as np
from lgmd2jax._compute.traced_once import traced_once

traced, values = [], {}

def ask(name, function, *args, **kwargs):
    values[name] = np.asarray(function(*args, **kwargs)[0], float).tolist()

def noting(name, function):
    def noted(*args):
        traced.append(name)
        return function(*args)
    noted.__qualname__ = name
    return traced_once(noted)

add = noting("add", lambda pair, more: (pair["x"] + more, "text", None))
x = jnp.linspace(0.0, 1.0, 3)
ask("add", add, {"x": x}, 1.0)
ask("other values", add, {"x": 2 * x}, 1.0)
ask("other number", add, {"x": x}, 2.0)
ask("other type of number", add, {"x": x}, 2)
ask("other shape", add, {"x": x[:2]}, 1.0)
ask("other dtype", add, {"x": x.astype(int)}, 1.0)
with jax.enable_x64(True):
    ask("other width", add, {"x": x}, 1.0)
ask("lapack", noting("solve", lambda a: (jnp.linalg.solve(a, jnp.ones(2)), 0)), jnp.array([[2.0, 0.0], [0.0, 4.0]]))
ask("inside", noting("outer", lambda x: (jnp.sum(add({"x": x}, 1.0)[0]), 0)), x)
back = lambda x: (jax.pure_callback(lambda x: x + np.float32(1), jax.ShapeDtypeStruct((), jnp.float32), x), 0)
ask("calls back", noting("back", back), jnp.float32(1))
with jax.disable_jit():
    ask("a line at a time", add, {"x": x}, 1.0)
rest = add({"x": x}, 1.0)[1:]
print(json.dumps([traced, values, rest]))
"""
VALUES = {
    "add": [1.0, 1.5, 2.0],
    "other values": [1.0, 2.0, 3.0],
    "other number": [2.0, 2.5, 3.0],
    "other type of number": [2.0, 2.5, 3.0],
    "other shape": [1.0, 1.5],
    "other dtype": [1.0, 1.0, 2.0],
    "other width": [1.0, 1.5, 2.0],
    "lapack": [0.5, 0.25],
    "inside": 4.5,
    "calls back": 2.0,
    "a line at a time": [1.0, 1.5, 2.0],
}
TRACED = ["add"] * 6 + ["solve", "outer", "add"]  # within another one a program is a part of that
NEVER_KEPT = ["back"] * 2 + ["add"]  # what calls back once to find that it cannot be kept, and what is not compiled


@pytest.fixture
def start(tmp_path):
    def start(**more):
        """What was traced, and what came out."""
        user = {name: value for name, value in os.environ.items() if not name.startswith(("JAX_", "XLA_"))}
        quiet = {"TF_CPP_MIN_LOG_LEVEL": "3"}  # as `keep_programs` sets it where XLA errs
        environment = user | quiet | {"JAX_COMPILATION_CACHE_DIR": str(tmp_path)} | more
        done = subprocess.run([sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True)
        assert (done.returncode, done.stderr) == (0, "")
        traced, values, rest = json.loads(done.stdout)
        assert values == VALUES
        assert rest == ["text", None]
        return traced

    return start


def test_the_next_start_traces_nothing_that_can_be_kept(start, tmp_path):
    assert start() == TRACED + NEVER_KEPT
    assert start() == NEVER_KEPT
    cut_off, foreign, *others = sorted(tmp_path.glob("__main__.add-*"))
    assert len(others) == 4
    cut_off.write_bytes(cut_off.read_bytes()[:-40])
    foreign.write_bytes(b"no program")
    assert start() == ["add", "add", *NEVER_KEPT]
    assert start() == NEVER_KEPT  # what was spoilt is written anew
    assert start(XLA_FLAGS="--xla_cpu_enable_fast_math=false") == TRACED + NEVER_KEPT
    assert set(start(JAX_ENABLE_COMPILATION_CACHE="false")) == set(TRACED + NEVER_KEPT)
    for path in tmp_path.glob("__main__.*"):  # for a folder in its place root too is refused
        path.unlink()
        path.mkdir()
    assert start() == TRACED + NEVER_KEPT
