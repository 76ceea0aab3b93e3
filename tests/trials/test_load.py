"""Every format gives the same trials, and what is wrong in a file is told with its cure."""

import numpy as np
import pytest

import lgmd2jax as lgmd
from tests.trials import synthesis
from tests.trials.synthesis import WINDOW, recordings


@pytest.fixture(scope="module")
def made():
    return recordings(trials=4)


def trials_of(made):
    """The trials themselves, by no importer."""
    return lgmd.Trials(
        tuple(lgmd.Trial(it.animal, it.trial, {"l_over_v": it.l_over_v}, np.array(it.spikes), *WINDOW) for it in made)
    )


# By the ending: a writer, and what the file does not tell.
FORMATS = {
    "tidy.csv": (synthesis.write_tidy, {"window": WINDOW}),
    "European.csv": (lambda path, made: synthesis.write_tidy(path, made, ";", ",", bom=True), {"window": WINDOW}),
    "tabs.txt": (lambda path, made: synthesis.write_tidy(path, made, "\t"), {"window": WINDOW}),
    "names.csv": (synthesis.write_named_columns, {"window": WINDOW}),
    "labels.csv": (synthesis.write_labelled_columns, {"window": WINDOW}),
    "two_tables": (synthesis.write_two_tables, {}),
    "sheets.xlsx": (synthesis.write_workbook, {}),
    "structs.mat": (synthesis.write_matlab, {"window": WINDOW}),
    "cells.mat": (synthesis.write_matlab_73, {"window": WINDOW}),
}


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_gives_the_same_trials(name, made, tmp_path):
    write, told = FORMATS[name]
    write(tmp_path / name, made)
    assert lgmd.load_trials(tmp_path / name, **told) == trials_of(made)


def test_a_file_of_each_animal_gives_the_same_trials(made, tmp_path):
    for animal in "AB":
        synthesis.write_nwb(tmp_path / f"{animal}.nwb", [it for it in made if it.animal == animal])
    trials = lgmd.load_trials(tmp_path / "A.nwb", tmp_path / "B.nwb")
    assert trials == trials_of([it for it in made if it.animal in "AB"])


def test_an_export_of_spike2_gives_the_same_trials_counted_anew(made, tmp_path):
    own = [it for it in made if it.animal == "A"]
    synthesis.write_spike2(tmp_path / "A.txt", own)
    counted = [it._replace(trial=str(number)) for number, it in enumerate(own, start=1)]
    assert lgmd.load_trials(tmp_path / "A.txt", window=WINDOW) == trials_of(counted)


def test_a_file_that_neo_reads_gives_the_same_trials(made, tmp_path):
    own = [it for it in made if it.l_over_v == 20 and it.animal == "B"]
    synthesis.write_neo(tmp_path / "block.nix", own)
    assert lgmd.load_trials(tmp_path / "block.nix") == trials_of(own)


def test_objects_of_neo_give_the_same_trials(made):
    assert lgmd.load_trials(synthesis.neo_block(made)) == trials_of(made)


def test_a_trial_without_spikes_is_kept(made):
    (unseen,) = [trial for trial in trials_of(made).where(animal="A") if trial.name == synthesis.UNSEEN]
    assert not unseen.spikes_ms.size


def test_a_folder_of_two_tables_may_hold_notes(made, tmp_path):
    synthesis.write_two_tables(tmp_path / "session", made)
    (tmp_path / "session" / "notes.txt").write_text("the locust jumped")
    assert lgmd.load_trials(tmp_path / "session") == trials_of(made)


@pytest.mark.parametrize(
    ("header", "told"),
    [
        ("Animal ID;Trial;l/|v| (ms);Spike Times [s]", {}),
        ("locust\tsweep\tlv\ttimestamp_s", {}),
        ("subject,rep,loverV_ms,t", {"time_unit": "s"}),
        ("who,which,speed_ms,when_s", {"animal": "who", "trial": "which", "l_over_v": "speed_ms", "time": "when_s"}),
        ("animal,cell,trial,lv_ms,spike_s", {}),
    ],
)
def test_columns_are_known_by_many_names(header, told, tmp_path):
    separator = next(sign for sign in ";\t," if sign in header)
    cells = ["A", *["7"] * ("cell" in header), "1", "20"]
    rows = [separator.join([*cells, time]) for time in ("-0.25", "-0.05", "0.1")]
    (tmp_path / "spikes.csv").write_text("\n".join([header, *rows]))
    (trial,) = lgmd.load_trials(tmp_path / "spikes.csv", window=WINDOW, **told)
    assert (trial.animal, trial.name, trial.condition) == ("A", "1", {"l_over_v": 20.0})
    assert trial.spikes_ms.tolist() == [-250, -50, 100]


def test_a_column_a_trial_of_one_animal_needs_no_more_than_its_number(tmp_path):
    (tmp_path / "G07.txt").write_text("trial 1\ttrial 2\n-0.05\t-0.06\n0.1\t\n")
    trials = lgmd.load_trials(tmp_path / "G07.txt", time_unit="s", l_over_v=40)
    assert [(it.animal, it.name, it.condition, it.spikes_ms.tolist()) for it in trials] == [
        ("G07", "1", {"l_over_v": 40.0}, [-50, 100]),
        ("G07", "2", {"l_over_v": 40.0}, [-60]),
    ]
