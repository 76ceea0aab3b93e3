"""`lgmd2jax arena`: its table, its JSON and its figure, and what it refuses."""

import json
import re

import jax.numpy as jnp
import pytest
from PIL import Image

from lgmd2jax.arena import FrameDifference, detectors
from lgmd2jax.cli import arena as command, main

NAMES = ["none", "table1", "lgmd2", "lgmd1", "difference"]


def test_the_detectors_that_are_compared():
    assert list(detectors()) == NAMES


def test_numbers_and_figure(tmp_path, capsys, monkeypatch):
    """With detectors that compile fast in the place of networks."""
    fast = {name: FrameDifference(jnp.asarray(5.0 + place, jnp.float32)) for place, name in enumerate(NAMES)}
    monkeypatch.setattr(command, "detectors", lambda model: fast)
    line = ["--seeds", "2", "--seconds", "4", "--json", str(tmp_path / "a.json"), "--figure", str(tmp_path / "a.png")]
    assert main(["arena", *line]) == 0, capsys.readouterr().err
    measured = json.loads((tmp_path / "a.json").read_text())["detectors"]
    assert list(measured) == NAMES
    for measures in measured.values():
        assert set(measures) == {"collisions_per_metre", "coverage"}
        for estimate in measures.values():
            assert set(estimate) == {"value", "low", "high"}
            assert estimate["low"] <= estimate["value"] <= estimate["high"]
    lines = capsys.readouterr().out.splitlines()[:6]
    assert [line.split()[0] for line in lines[1:]] == NAMES
    assert len(set(map(len, lines))) == 1
    assert all(len(re.split(r" {2,}", line)) == 5 for line in lines)  # no two columns run together
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.width > picture.height


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--seeds", "0"], "--seeds is 0; give how many arenas, 1 to 10000"),
        (["--seeds", "99999999999"], "--seeds is 99999999999; give how many arenas"),
        (["--seconds", "0"], "--seconds is 0; give 1 to 3600"),
        (
            ["--figure", "arena.txt"],
            "cannot tell the format of the figure arena.txt; end its name in .png, .pdf or .svg",
        ),
        (["--model", "nothing"], "no such file: nothing"),
    ],
)
def test_what_is_refused(options, message, capsys):
    assert main(["arena", *options]) == 1
    assert capsys.readouterr().err.startswith(f"lgmd2jax: {message}")
