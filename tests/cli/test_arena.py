"""`lgmd2jax arena`: its table, its JSON and its figure, and what it refuses."""

import json

import pytest
from PIL import Image

from lgmd2jax.cli import main

NAMES = ["none", "table1", "lgmd2", "lgmd1", "difference"]


@pytest.fixture
def result(tmp_path, capsys):
    """What a second in two arenas leaves."""
    line = ["arena", "--seeds", "2", "--seconds", "1", "--json", "a.json", "--figure", "a.png"]
    line = [str(tmp_path / word) if word.startswith("a.") else word for word in line]
    assert main(line) == 0, capsys.readouterr().err
    return tmp_path, capsys.readouterr().out


def test_numbers_and_figure(result):
    folder, said = result
    detectors = json.loads((folder / "a.json").read_text())["detectors"]
    assert list(detectors) == NAMES
    for measures in detectors.values():
        assert set(measures) == {"collisions_per_metre", "coverage"}
        for estimate in measures.values():
            assert set(estimate) == {"value", "low", "high"}
            assert estimate["low"] <= estimate["value"] <= estimate["high"]
    assert [line.split()[0] for line in said.splitlines()[1:6]] == NAMES
    with Image.open(folder / "a.png") as picture:
        assert picture.width > picture.height


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--seeds", "0"], "--seeds is 0; give how many arenas, 1 or more"),
        (["--seconds", "0"], "--seconds is 0; give 1 to 3600"),
        (["--figure", "ways.txt"], "cannot tell the format of the figure ways.txt; end its name in .png, .pdf or .svg"),
        (["--model", "nothing"], "no such file: nothing"),
    ],
)
def test_what_is_refused(options, message, capsys):
    assert main(["arena", *options]) == 1
    assert capsys.readouterr().err.startswith(f"lgmd2jax: {message}")
