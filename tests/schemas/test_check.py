"""What is wrong with a document, in one line: the path of the key, the value, the cure."""

import datetime
import re

import pytest
from pydantic import TypeAdapter

from lgmd2jax._schemas.check import check, check_kind
from lgmd2jax._schemas.parts import Number, Positive, Text, Truth, Whole, by_key, inside, names, several, table

_ONE = table("One", {"kind": (names(["one"]), ...), "level": several(Positive)})
_OTHER = table("Other", {"kind": (names(["other"]), ...), "mode": names(["exact", "rough"])})
SCHEMA = TypeAdapter(
    table(
        "Document",
        {
            "count": Whole,
            "size": Number,
            "share": inside("[0, 1)"),
            "flag": Truth,
            "word": Text,
            "part": list[by_key("kind", {"one": _ONE, "other": _OTHER})],
            "named": dict[Text, Number],
        },
    )
)


@pytest.mark.parametrize(
    "document",
    [
        {},
        {"count": 3, "size": 2, "share": 0, "flag": True, "word": ""},
        {"part": [{"kind": "one", "level": 2}, {"kind": "one", "level": [1, 2.5]}, {"kind": "other", "mode": "exact"}]},
    ],
)
def test_what_is_right_passes(document):
    check(SCHEMA, document)


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ([1], "document = [1]: must be a table"),
        ({"cuont": 1}, "cuont = 1: unknown key; did you mean 'count'?"),
        ({"count": 1.0}, "count = 1.0: must be a whole number"),
        ({"count": True}, "count = true: must be a whole number"),
        ({"size": False}, "size = false: must be a number"),
        ({"size": "3"}, "size = '3': must be a number"),
        ({"size": None}, "size = null: must be a number"),
        ({"size": float("nan")}, "size = nan: must be a finite number"),
        ({"size": float("inf")}, "size = inf: must be a finite number"),
        ({"size": datetime.date(2026, 1, 2)}, "size = datetime.date(2026, 1, 2): must be a number"),
        ({"share": 1}, "share = 1: must be below 1"),
        ({"share": -0.5}, "share = -0.5: must be 0 or more"),
        ({"flag": 1}, "flag = 1: must be true or false"),
        ({"word": 3}, "word = 3: must be a text"),
        ({"word": "a\nb", "flag": "c\nd"}, r"flag = 'c\nd': must be true or false"),
        ({"part": {"kind": "one"}}, "part = {'kind': 'one'}: must be a list; write each table under [[part]]"),
        ({"part": [{}]}, "part[0].kind is missing; choose 'one' or 'other'"),
        ({"part": [{"kind": "oter"}]}, "part[0].kind = 'oter': choose 'other' or 'one'"),
        ({"part": [{"kind": ["one"]}]}, "part[0].kind = ['one']: choose 'one' or 'other'"),
        ({"part": [{"kind": "one", "level": [1, [2]]}]}, "part[0].level[1] = [2]: must be a number"),
        ({"part": [{"kind": "one", "level": -1}]}, "part[0].level = -1: must be above 0"),
        ({"part": [{"kind": "one", "level": []}]}, "part[0].level = []: must hold 1 or more values"),
        ({"part": [{"kind": "other", "level": 1}]}, "part[0].level = 1: unknown key; did you mean 'mode'?"),
        ({"named": {"a b.c": "x"}}, "named.'a b.c' = 'x': must be a number"),
    ],
)
def test_what_is_wrong_is_said_with_path_value_and_cure(document, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        check(SCHEMA, document)


def test_a_huge_number_is_shown_short():
    with pytest.raises(ValueError, match=r"^size = 10+\.\.\.0+: is too large for a number$") as caught:
        check(SCHEMA, {"size": 10**400})
    assert len(str(caught.value)) < 120


def test_a_long_value_is_cut():
    with pytest.raises(ValueError, match=r"^count = \[\[\[.*\.\.\.: must be a whole number$") as caught:
        check(SCHEMA, {"count": [[[100 + i for i in range(9)]] * 9] * 9})
    assert len(str(caught.value)) < 200


def test_three_faults_are_told_and_the_others_counted():
    with pytest.raises(ValueError, match=r"; and 1 more$") as caught:
        check(SCHEMA, {"count": "a", "size": "b", "flag": "c", "word": 4})
    assert str(caught.value).count(": must be") == 3


@pytest.mark.parametrize(
    ("document", "wanted", "message"),
    [
        ({"eye": {}, "condition": []}, "recipe", "it is a protocol of stimuli, not a recipe; see lgmd2jax fit --help"),
        ({"eye": {}, "clip": []}, "protocol", "it is a file of labelled clips, not a protocol"),
        ({"protocol": "a"}, "labels", "it is a recipe, not a file of labelled clips; see lgmd2jax watch --help"),
    ],
)
def test_a_document_of_another_kind_is_called_by_its_name(document, wanted, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
        check_kind(document, wanted)
    check_kind({"eye": {}}, wanted)  # which any of them may have
    check_kind({"protocol": "a", "condition": [], "clip": []}, wanted)  # a wrong key beside its own is told by `check`
