"""The command that changes single lines: each is there once, and a quick one is run."""

from pathlib import Path

import pytest

from benchmarks.mutants import MUTANTS, ROOT, Mutant, main, outcome


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: f"{Path(mutant.file).stem}: {mutant.right:.40}")
def test_its_line_stands_once_and_its_test_is_there(mutant):
    assert (ROOT / mutant.file).read_text(encoding="utf-8").count(mutant.right) == 1
    file, _, name = mutant.test.partition("::")
    assert f"def {name}(" in (ROOT / file).read_text(encoding="utf-8") or not name


def test_a_mutant_dies_and_the_command_says_so(capsys):
    (number,) = (i for i, mutant in enumerate(MUTANTS, 1) if "_FACTOR" in mutant.right)
    assert main([str(number)]) == 0
    assert "1 of 1 mutants die" in capsys.readouterr().out


@pytest.mark.slow
def test_a_change_that_means_nothing_lives():
    assert (
        outcome(Mutant("lgmd2jax/_words.py", "likeliest first", "likely ones first", "tests/test_channels.py"))
        == "LIVES"
    )
