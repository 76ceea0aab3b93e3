"""Hand-over files with anything in them: taken, or refused in a sentence, and never otherwise."""

import json

import hypothesis
import hypothesis.strategies as st
import pytest

import lgmd2jax as lgmd
from benchmarks._fuzz_mutants import mutated
from lgmd2jax import hard


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("load", "name"), [(hard.load, "rich"), (lgmd.load, "rich"), (lgmd.load, "lgmd1")], ids=["robot", "LGMD2", "LGMD1"]
)
def test_a_mutated_file_is_taken_or_refused_in_a_sentence(others, tmp_path, load, name):
    document, path = json.loads((others / f"{name}.json").read_text()), tmp_path / "model.json"
    said = set()

    @hypothesis.settings(max_examples=150, deadline=None, derandomize=True, database=None)
    @hypothesis.given(st.data())
    def attempt(data):
        path.write_text(json.dumps(mutated(data, document), default=str))
        try:
            load(path)
            said.add("")
        except (ValueError, OSError) as error:
            said.add(str(error))

    attempt()
    assert "" in said
    assert len(said) > 30
    assert not [it for it in said - {""} if str(path) not in it or "\n" in it]


@pytest.mark.usefixtures("untyped")
def test_the_robot_and_the_library_refuse_the_same_files(others, tmp_path):
    document, path = json.loads((others / "rich.json").read_text()), tmp_path / "model.json"
    verdicts = set()

    def takes(load):
        try:
            load(path)
        except (ValueError, OSError):
            return False
        return True

    @hypothesis.settings(max_examples=300, deadline=None, derandomize=True, database=None)
    @hypothesis.given(st.data())
    def attempt(data):
        path.write_text(json.dumps(mutated(data, document), default=str))
        verdict = takes(lgmd.load)
        assert takes(hard.load) == verdict
        verdicts.add(verdict)

    attempt()
    assert verdicts == {True, False}
