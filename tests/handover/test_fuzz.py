"""Hand-over files with anything in them: taken, or refused in a sentence, and never otherwise."""

import copy
import json
from typing import Any

import hypothesis
import hypothesis.strategies as st
import pytest

import lgmd2jax as lgmd
from lgmd2jax import hard

EXTREME = [10**400, -(10**30), 1e308, -1e308, 5e-324, float("nan"), float("inf"), 2**63, 0, -1, 256, True, None]
LEAVES = st.one_of(st.sampled_from(EXTREME), st.integers(), st.floats(), st.text(max_size=5))
ANYTHING = st.recursive(
    LEAVES,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)


def mutated(data: st.DataObject, document: Any) -> Any:
    """The document with one value, at any depth, replaced, dropped, named otherwise or put elsewhere."""
    document = copy.deepcopy(document)
    place = document
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        key = data.draw(st.sampled_from(keys))
        inner = place[key]
        if not (isinstance(inner, (dict, list)) and inner) or data.draw(st.integers(0, 3)) == 0:
            break
        place = inner
    change = data.draw(st.sampled_from(["replace", "replace", "drop", "rename", "nest"]))
    if change == "replace":
        place[key] = data.draw(ANYTHING)
    elif change == "nest":
        place[key] = [inner, inner]
    else:
        place.pop(key)
        if change == "rename" and isinstance(place, dict):
            place[data.draw(st.text(max_size=5) | st.sampled_from(["N_sp", "T_p", "lag", "eye", "network"]))] = inner
    return document


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
        path.write_text(json.dumps(mutated(data, document)))
        try:
            load(path)
            said.add("")
        except (ValueError, OSError) as error:
            said.add(str(error))

    attempt()
    assert "" in said
    assert len(said) > 30
    assert all(str(path) in sentence and "\n" not in sentence for sentence in said - {""})


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
        path.write_text(json.dumps(mutated(data, document)))
        verdict = takes(lgmd.load)
        assert takes(hard.load) == verdict
        verdicts.add(verdict)

    attempt()
    assert verdicts == {True, False}
