"""Every layout of a text file gives the same trials, and what is wrong in one is told with its cure."""

import numpy as np
import pytest

import lgmd2jax as lgmd
from tests.trials import synthesis
from tests.trials.synthesis import WINDOW, recordings


@pytest.fixture(scope="module")
def made():
    return recordings()


@pytest.fixture(scope="module")
def known(made):
    """The trials themselves, by no importer."""
    return lgmd.Trials(
        tuple(lgmd.Trial(it.animal, it.trial, {"l_over_v": it.l_over_v}, np.array(it.spikes), *WINDOW) for it in made)
    )


LAYOUTS = {
    "tidy": lambda path, made: synthesis.write_tidy(path, made),
    "tidy, European, with a byte order mark": lambda path, made: synthesis.write_tidy(path, made, ";", ",", bom=True),
    "tidy, tabs": lambda path, made: synthesis.write_tidy(path, made, "\t"),
    "columns by name": synthesis.write_named_columns,
    "columns with labels": synthesis.write_labelled_columns,
    "two tables": synthesis.write_two_tables,
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_gives_the_same_trials(layout, made, known, tmp_path):
    path = tmp_path / ("folder" if layout == "two tables" else "spikes.csv")
    LAYOUTS[layout](path, made)
    assert lgmd.load_trials(path, window=None if layout == "two tables" else WINDOW) == known


def test_a_trial_without_spikes_is_kept(known):
    (unseen,) = [trial for trial in known.where(animal="A") if trial.name == synthesis.UNSEEN]
    assert not unseen.spikes_ms.size
