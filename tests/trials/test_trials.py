"""Trials as an object: sorted, chosen by condition, handed to a fit."""

import numpy as np
import pytest

import lgmd2jax as lgmd


def trial(animal="A", name="1", speed=20.0, spikes=(-50.0,), span=(-100.0, 100.0), **condition):
    return lgmd.Trial(animal, name, {"l_over_v": speed, **condition}, np.array(spikes, dtype=float), *span)


def test_trials_are_sorted_by_numbers_within_their_names_and_spikes_by_time():
    trials = lgmd.Trials((trial("B"), trial(name="10"), trial(name="9", spikes=(3.0, -4.0)), trial("A2"), trial("A10")))
    assert [(it.animal, it.name) for it in trials] == [("A", "9"), ("A", "10"), ("A2", "1"), ("A10", "1"), ("B", "1")]
    assert trials.trials[0].spikes_ms.tolist() == [-4, 3]
    assert trials.animals == ("A", "A2", "A10", "B")


def test_conditions_are_chosen_by_their_values():
    trials = lgmd.Trials((trial(shape="disc"), trial(shape="square"), trial(speed=5.0, shape="disc")))
    assert trials.conditions == (
        {"l_over_v": 5.0, "shape": "disc"},
        {"l_over_v": 20.0, "shape": "disc"},
        {"l_over_v": 20.0, "shape": "square"},
    )
    assert len(trials.where(shape="disc")) == 2
    assert len(trials.where(animal="A", l_over_v=20, shape="disc")) == 1
    with pytest.raises(ValueError, match="no condition has 'form'; choose"):
        trials.where(form="disc")
    with pytest.raises(ValueError, match="no trial has animal = 'Z'"):
        trials.where(animal="Z")


def test_a_fit_gets_every_animal_with_all_its_trials_also_the_silent_ones():
    trains = lgmd.Trials((trial(), trial(name="2", spikes=()), trial("B", spikes=(1.0, 2.0)))).spike_trains(30)
    assert [[np.asarray(train).tolist() for train in animal] for animal in trains.trials] == [[[-50], []], [[1, 2]]]
    assert trains.kernel_ms == 30
    assert trains.animals == ("A", "B")


def test_silence_before_an_approach_can_be_fitted():
    """Where no animal fires at all, the standard error over animals is not 0."""
    silent = [trial(animal, str(number), spikes=(-20.0 + 20 * number, 90.0)) for animal in "AB" for number in range(2)]
    trains = lgmd.Trials(tuple(silent)).spike_trains(5.0)
    target = lgmd.spike_rate(trains.trials, np.arange(-100.0, 101.0, 20.0), trains.kernel_ms)
    assert target.sem is not None
    assert np.all(target.sem > 0)


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (lambda: trial(spikes=(150.0,)), "reaches from -100 to 100 ms, and a spike lies at 150 ms"),
        (lambda: trial(spikes=(np.nan,)), "no finite numbers"),
        (lambda: trial(span=(100.0, -100.0)), "ends at -100 ms and starts at 100 ms"),
        (lambda: lgmd.Trials(()), "there are no trials"),
        (lambda: lgmd.Trials((trial(), trial())), "is given twice"),
        (lambda: lgmd.load_trials(), "no file is named"),
    ],
)
def test_trials_that_cannot_be_are_refused(made, words):
    with pytest.raises(ValueError, match=words):
        made()


@pytest.mark.slow
def test_the_recorded_dcmd_of_nguyen_et_al(data):
    """The published recordings give alpha 4.36 and r2 .967 over 12 animals, which were shown further l/|v|."""
    folder = data / "dcmd_trials"
    if not folder.is_dir():
        pytest.skip(f"no recordings at {folder}")
    trials = lgmd.load_trials(folder)
    assert len(trials) == 1904 - 15  # of G30, which appear twice
    assert sum(not trial.spikes_ms.size for trial in trials) > 50
    law = trials.looming_law(resamples=200)
    assert list(law.animals) == [f"G{number:02}" for number in range(9, 18)]
    assert law.pooled.alpha.value == pytest.approx(4.36, abs=0.3)
    assert law.pooled.alpha.low < 4.36 < law.pooled.alpha.high
    assert law.pooled.r2 == pytest.approx(0.967, abs=0.02)
    # Latencies of tablet and sound card, some 55 ms, are within delta.
    assert 15 < law.pooled.delta_ms.value - 55 < 35
    assert all(times.alpha.high > 2.75 and times.alpha.low < 7.6 for times in law.animals.values())
    noise = {item.animal for item in law.excluded if "as of noise" in item.reason}
    assert noise == {"G18", "G19", "G20", "G21"}
