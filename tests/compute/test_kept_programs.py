"""Compiled programs on disk: read by a second start, with the same result; where they cannot be, nothing is said."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from lgmd2jax._compute import kept_programs
from lgmd2jax._compute.kept_programs import keep_programs, place_of_programs, programs_folder

KEEP = """
from lgmd2jax._compute.kept_programs import keep_programs
keep_programs()
"""
COMPUTE = """
import json, jax, jax.numpy as jnp
read = []
jax.monitoring.register_event_listener(lambda name, **_: read.append(name) if name.endswith("cache_hits") else None)
x = jnp.linspace(0.0, 1.0, 64)
value = jax.jit(lambda x: jax.lax.scan(lambda s, x: (jnp.tanh(s + x), s * x), x.sum(), x)[1].sum())(x)
print(json.dumps([len(read), float(value).hex()]))
"""
PROGRAM = KEEP + COMPUTE
IN_A_PROCESS_OF_ITS_OWN = (
    f"{KEEP}import subprocess, sys\nsubprocess.run([sys.executable, '-c', {COMPUTE!r}], check=True)"
)


class Starts:
    """Starts of the program, each in a process, with a cache of their own."""

    def __init__(self, folder):
        self.folder = folder
        user = {name: value for name, value in os.environ.items() if not name.startswith(("JAX_", "XLA_", "TF_"))}
        self.environment = user | dict.fromkeys(("XDG_CACHE_HOME", "HOME", "LOCALAPPDATA"), str(folder))

    def process(self, program=PROGRAM, **more):
        line = [sys.executable, "-c", program]
        pipe = subprocess.PIPE
        return subprocess.Popen(line, env=self.environment | more, stdout=pipe, stderr=pipe, text=True)

    def __call__(self, program=PROGRAM, **more):
        """How many compiled programs were read, and the value."""
        started = self.process(program, **more)
        out, error = started.communicate()
        assert (started.returncode, error) == (0, "")
        return json.loads(out)

    def kept(self):
        return sorted(self.folder.rglob("*-cache"))


@pytest.fixture
def start(tmp_path):
    return Starts(tmp_path)


def test_a_second_start_reads_what_the_first_one_compiled_and_answers_the_same(start):
    first, value = start()
    assert first == 0
    assert start.kept()
    second, again = start()
    assert second == len(start.kept())
    assert again == value
    assert start(JAX_ENABLE_COMPILATION_CACHE="true") == [second, value]
    assert start(JAX_ENABLE_COMPILATION_CACHE="false") == [0, value]


def test_spoilt_programs_cost_time_alone(start):
    _, value = start()
    cut_off, foreign, *_ = start.kept()
    cut_off.write_bytes(cut_off.read_bytes()[:-40])
    foreign.write_bytes(b"no program")
    assert start() == [len(start.kept()) - 2, value]
    assert start() == [len(start.kept()), value]  # what was spoilt is written anew


def test_spoilt_programs_cost_a_process_that_a_start_begins_time_alone(start):
    _, value = start()
    for path in start.kept():
        path.write_bytes(b"no program")
    assert start(IN_A_PROCESS_OF_ITS_OWN) == [0, value]


def test_without_a_home_nothing_is_kept(start):
    """By a home that is none, which Python meets as it meets a user without one."""
    assert start(HOME="~", XDG_CACHE_HOME="")[0] == 0
    assert not start.kept()


def test_a_file_where_the_folder_should_be_costs_time_alone(start, tmp_path):
    (tmp_path / "lgmd2jax").write_text("mine")
    assert start()[0] == 0
    assert (tmp_path / "lgmd2jax").read_text() == "mine"


def test_a_folder_that_cannot_be_written_costs_time_alone(start):
    """By folders in the places of the programs, for which root too is refused."""
    start()
    for path in start.kept():
        path.unlink()
        path.mkdir()
    assert start()[0] == 0


def test_two_starts_at_once_answer_the_same(start):
    outputs = [process.communicate() for process in [start.process(), start.process()]]
    assert [error for _, error in outputs] == ["", ""]
    assert len({json.loads(out)[1] for out, _ in outputs}) == 1


def test_the_programs_that_were_used_longest_ago_go(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(kept_programs, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(kept_programs, "LIMIT", 250)
    for name in ("COMPILATION_CACHE_DIR", "ENABLE_COMPILATION_CACHE"):
        monkeypatch.setenv(f"JAX_{name}", "")  # so that it is put back after the test
        monkeypatch.delenv(f"JAX_{name}")
    for name in ("MIN_COMPILE_TIME_SECS", "MIN_ENTRY_SIZE_BYTES"):
        monkeypatch.setenv(f"JAX_PERSISTENT_CACHE_{name}", "0")
    old = tmp_path / "programs" / "jaxlib-0.1"
    old.mkdir(parents=True)
    for age, name in enumerate("abcd"):
        (old / f"{name}-cache").write_bytes(bytes(100))
        os.utime(old / f"{name}-cache", (10**9 - age, 10**9 - age))
    for name in ("PYTHONWARNINGS", "LGMD2JAX_PROGRAMS"):
        monkeypatch.setenv(name, "")
    keep_programs()
    assert sorted(path.name for path in old.iterdir()) == ["a-cache", "b-cache"]
    assert os.environ["JAX_COMPILATION_CACHE_DIR"] == str(programs_folder())
    assert programs_folder().is_dir()


def test_a_user_who_decided_is_not_overruled(tmp_path, monkeypatch):
    monkeypatch.setattr(kept_programs, "cache_folder", lambda: tmp_path)
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", "mine")
    monkeypatch.setenv("JAX_ENABLE_COMPILATION_CACHE", "true")
    monkeypatch.setenv("LGMD2JAX_PROGRAMS", "")
    keep_programs()
    assert os.environ["JAX_COMPILATION_CACHE_DIR"] == "mine"
    assert place_of_programs() == Path("mine")
    assert not list(tmp_path.iterdir())
