"""lgmd2jax import: what recordings hold, and a protocol that a fit aims at."""

import tomllib

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.cli import main
from tests.trials.synthesis import NOISY, SPEEDS, WINDOW, recordings, write_tidy, write_two_tables

SCREEN = ["--fps", "50", "--stop-angle", "70", "--contrast", "-1", "--background", "180"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """An import of the two tables, made once."""
    place = tmp_path_factory.mktemp("import")
    write_two_tables(place / "recordings", recordings("AB" + NOISY, trials=4))
    assert main(["import", str(place / "recordings"), "-o", str(place / "mine"), *SCREEN]) == 0
    return place / "mine"


def test_the_protocol_shows_the_looms_and_aims_at_the_trials_that_answer(folder):
    conditions = lgmd.load_protocol(folder / "protocol.toml").conditions
    assert [condition.parameters["l_over_v"] for condition in conditions] == list(SPEEDS)
    trials = lgmd.load_trials(folder.parent / "recordings")
    for condition, speed in zip(conditions, SPEEDS, strict=True):
        assert condition.eye.fps == 50
        assert condition.parameters["stop_angle"] == 70
        assert condition.parameters["contrast"] == -1
        assert condition.parameters["background"] == 180
        assert (condition.parameters["start_ms"], condition.parameters["end_ms"]) == WINDOW
        (target,) = condition.targets
        assert isinstance(target, lgmd.SpikeTrains)
        time = np.arange(-300.0, 301.0, 20.0)
        known = [[t.spikes_ms for t in trials.where(animal=animal, l_over_v=speed)] for animal in "AB"]
        one, other = (lgmd.spike_rate(trains, time).values for trains in (target.trials, known))
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_the_folder_gives_the_same_trials_again(folder):
    assert lgmd.load_trials(folder) == lgmd.load_trials(folder.parent / "recordings")


@pytest.mark.slow
def test_the_recipe_can_be_run(folder):
    recipe = lgmd.load_recipe(folder / "fit.toml")
    assert isinstance(recipe, lgmd.Recipe)
    assert len(recipe.pairs) == len(SPEEDS)
    assert "latency" in recipe.free.names
    assert list(recipe.animals) == ["A", "B"]


def test_it_says_what_was_found_and_what_is_assumed(folder, tmp_path, capsys):
    arguments = ["import", str(folder.parent / "recordings"), "-o", str(tmp_path / "mine")]
    assert main(arguments) == 0
    printed = capsys.readouterr().out
    assert f"trials that look like noise: {4 * len(SPEEDS)} of {12 * len(SPEEDS)} ({NOISY} 16)" in printed
    assert "assumed: --fps 60, --stop-angle 80" in printed
    assert f"left out of the targets: {NOISY}: base rate" in printed
    text = (tmp_path / "mine" / "protocol.toml").read_text(encoding="utf-8")
    assert text.count("# assumed") == 1 + 3 * len(SPEEDS)
    assert tomllib.loads(text)["eye"]["fps"] == 60


def test_a_folder_is_replaced_only_where_that_is_said(folder, capsys):
    arguments = ["import", str(folder.parent / "recordings"), "-o", str(folder), *SCREEN]
    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    assert main(arguments) == 1
    assert "--replace" in capsys.readouterr().err
    (folder / "notes.txt.keep").write_text("mine")
    assert main([*arguments, "--replace"]) == 0
    assert (folder / "notes.txt.keep").read_text() == "mine"
    (folder / "notes.txt.keep").unlink()
    after = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file() and file.suffix != ".png"}
    assert after == {file: content for file, content in before.items() if file.suffix != ".png"}


@pytest.mark.parametrize("options", [["--time-unit", "ms"], ["--event", "nothing"]])
def test_what_fails_leaves_nothing(options, tmp_path, capsys):
    write_tidy(tmp_path / "spikes.csv", [it._replace(spikes=[t / 1000 for t in it.spikes]) for it in recordings("A")])
    assert main(["import", str(tmp_path / "spikes.csv"), "-o", str(tmp_path / "mine"), *options]) == 1
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert [file.name for file in tmp_path.iterdir()] == ["spikes.csv"]


@pytest.mark.parametrize(
    ("options", "contrast", "words"),
    [
        (["--fps", "0"], "", "fps is 0.0; give a positive number"),
        (["--fps", "1e9"], "", "fps is 1e+09; no screen shows more"),
        (["--stop-angle", "200"], "", "stop_angle is 200.0 degrees; give a number in 0..179"),
        (["--contrast", "-90"], "", "the object would be at grey level -1.78e+04"),
        (["--background", "300"], "", "background is 300.0 grey levels; give a number in 0..255"),
        ([], "-90%", "contrast is '-90%' in the recordings; write a number there, such as -0.9"),
        ([], "-90", "contrast is -90.0 on a background of 200"),
    ],
)
def test_what_no_screen_shows_is_refused(options, contrast, words, tmp_path, capsys):
    write_tidy(tmp_path / "spikes.csv", recordings("A"))
    if contrast:
        header, *rows = (tmp_path / "spikes.csv").read_text().splitlines()
        text = "\n".join([f"contrast,{header}", *(f"{contrast},{row}" for row in rows)])
        (tmp_path / "spikes.csv").write_text(text + "\n")
    assert main(["import", str(tmp_path / "spikes.csv"), "-o", str(tmp_path / "mine"), *options]) == 1
    assert words in (said := capsys.readouterr().err)
    assert said.count("\n") == 1
    assert [file.name for file in tmp_path.iterdir()] == ["spikes.csv"]


def test_a_file_in_the_folders_place_is_one_line(tmp_path, capsys):
    write_tidy(tmp_path / "spikes.csv", recordings("A"))
    assert main(["import", str(tmp_path / "spikes.csv"), "-o", str(tmp_path / "spikes.csv")]) == 1
    assert "spikes.csv exists and is not a folder; name another one" in capsys.readouterr().err


def test_recordings_at_one_speed_are_kept(tmp_path, capsys):
    """They have no line of peak times, but a fit can aim at them."""
    write_tidy(tmp_path / "spikes.csv", [it for it in recordings("A", trials=4) if it.l_over_v == 20])
    assert main(["import", str(tmp_path / "spikes.csv"), "-o", str(tmp_path / "mine"), *SCREEN]) == 0
    assert "left out" not in capsys.readouterr().out
    assert [file.name for file in (tmp_path / "mine" / "targets").iterdir()] == ["approach_20_ms.csv"]
