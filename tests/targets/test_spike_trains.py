"""Rates from spike times: the kernel, the mean over animals, its standard error."""

import math

import jax.numpy as jnp
import numpy as np
import pytest

from lgmd2jax._targets.csv_files import read_spike_trains
from lgmd2jax._targets.spike_trains import SpikeTrains, spike_rate
from lgmd2jax.stimuli import Stimulus

TIME = np.arange(-40, 41) * 10.0
STIMULUS = Stimulus(jnp.zeros((81, 3, 3)), 100.0, jnp.asarray(TIME))
EDGES = [-1000.0, 1000.0]  # spikes that say how far the recordings reach


def poisson(rng, rate, start, end):
    """Spike times of a steady rate in spikes/s."""
    return rng.uniform(start, end, rng.poisson(rate * (end - start) / 1000))


def test_a_spike_is_a_gaussian_of_one_spike():
    target = spike_rate([[[13.0, *EDGES]]], TIME, 30.0)
    expected = 1000 / (30 * math.sqrt(2 * math.pi)) * np.exp(-0.5 * ((TIME - 13) / 30) ** 2)
    np.testing.assert_allclose(target.values, expected, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(np.sum(target.values) * 10 / 1000, 1, rtol=1e-9)
    assert target.sem is None
    assert target.channel == "rate"


def test_it_is_the_mean_over_animals_of_means_over_trials_by_a_plain_loop():
    rng = np.random.default_rng(1)
    trials = [[poisson(rng, 20 * (1 + animal), -400, 400) for _ in range(2 + animal)] for animal in range(3)]
    target = spike_rate(trials, TIME, 25.0)
    start = min(-400.0, *(spike for animal in trials for trial in animal for spike in trial))
    end = max(400.0, *(spike for animal in trials for trial in animal for spike in trial))
    for i in (0, 1, 7, 40, 80):
        animals = []
        for animal in trials:
            rates = []
            for trial in animal:
                total = sum(math.exp(-((TIME[i] - spike) ** 2) / (2 * 25.0**2)) for spike in trial)
                grid = np.linspace(start, end, 20_001)
                kernel = np.exp(-((TIME[i] - grid) ** 2) / (2 * 25.0**2))
                rates.append(1000 * total / np.trapezoid(kernel, grid))
            animals.append(sum(rates) / len(rates))
        mean = sum(animals) / 3
        np.testing.assert_allclose(target.values[i], mean, rtol=1e-6)
        assert target.sem is not None
        spread = math.sqrt(sum((animal - mean) ** 2 for animal in animals) / 2)
        np.testing.assert_allclose(target.sem[i], spread / math.sqrt(3), rtol=1e-6)


def test_a_steady_rate_comes_back_up_to_the_ends():
    """R = 60 spikes/s in N = 400 trials: a sample has the standard deviation sqrt(R/N/(2 sqrt(pi) kernel))."""
    rng = np.random.default_rng(2)
    trials = [[poisson(rng, 60.0, -400, 400) for _ in range(40)] for _ in range(10)]
    target = spike_rate(trials, TIME, 20.0)
    spread = math.sqrt(60 / 400 / (2 * math.sqrt(math.pi) * 0.020))
    np.testing.assert_allclose(target.values[8:-8], 60, atol=4 * spread)
    np.testing.assert_allclose(target.values, 60, atol=6 * spread)
    assert target.sem is not None
    np.testing.assert_allclose(np.mean(target.sem[8:-8]), spread, rtol=0.15)


def test_the_error_is_that_over_animals_and_not_over_trials():
    """Animals at 10, 30 and 50 spikes/s: however many trials, the mean is known to 20/sqrt(3)."""
    regular = [[np.arange(-1000, 1000, 1000 / rate) for _ in range(7)] for rate in (10, 30, 50)]
    target = spike_rate(regular, TIME, 100.0)
    np.testing.assert_allclose(target.values, 30, atol=0.5)
    assert target.sem is not None
    np.testing.assert_allclose(target.sem, 20 / math.sqrt(3), rtol=0.03)


def test_correlation_is_that_of_smoothed_noise():
    """White noise behind the kernel, without a formula: the span is the sum of its autocorrelation."""
    target = spike_rate([[EDGES]], TIME, 20.0)
    lags = np.arange(-300, 301) * 1.0
    kernel = np.exp(-0.5 * (lags / 20) ** 2)
    autocorrelation = np.convolve(kernel, kernel) / np.sum(kernel**2)
    np.testing.assert_allclose(target.correlation_ms, np.sum(autocorrelation), rtol=1e-9)
    np.testing.assert_allclose(target.correlation_ms, 70.9, atol=0.01)


def test_a_trial_without_spikes_counts():
    spikes = [0.0, *EDGES]
    alone, diluted = (spike_rate([trials], TIME).values for trials in ([spikes], [spikes, []]))
    np.testing.assert_allclose(diluted, alone / 2)


def test_silence_is_a_rate_of_zero():
    np.testing.assert_array_equal(spike_rate([[[]], [[]]], TIME).values, 0)


def test_trains_become_a_target_at_any_frames():
    trains = SpikeTrains([[[13.0, *EDGES]], [[-50.0]]], kernel_ms=30.0)
    target = trains.on(STIMULUS)
    np.testing.assert_array_equal(target.values, spike_rate(trains.trials, TIME, 30.0).values)
    assert target.thinning == pytest.approx(2 * math.sqrt(math.pi) * 30 / 10)


def test_trains_are_read_from_a_file(tmp_path):
    (tmp_path / "spikes.csv").write_text(
        "\ufeffanimal,trial,time_ms\nA,1,-3.5\nB,1,20\nA,1,7\nA,2,\nB,2,5e1\n\n", encoding="utf-8"
    )
    trains = read_spike_trains(tmp_path / "spikes.csv", kernel_ms=15.0)
    assert trains == SpikeTrains([[[-3.5, 7.0], []], [[20.0], [50.0]]], 15.0)
    (tmp_path / "other.csv").write_text("cell,sweep,t,note\nA,1,3,x\n")
    assert read_spike_trains(tmp_path / "other.csv", animal="cell", trial="sweep", time="t").trials == [[[3.0]]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("animal,trial,time\nA,1,3\n", r"spikes.csv: no column 'time_ms'; choose 'time' or"),
        (
            "animal,trial,time_ms\nA,1,3\nA,1,x\n",
            r"spikes.csv: column 'time_ms' holds 'x' in row 2, which is no finite",
        ),
        ("animal,trial,time_ms\nA,1,nan\n", "holds 'nan' in row 1"),
        ("animal,trial,time_ms\nA,,3\n", "row 1 lacks its trial"),
        ("animal,trial,time_ms\n,1,3\n", "row 1 lacks its animal"),
        ("animal,trial,time_ms\nA,1\n", "row 1 has 2 cells and the header 3"),
        ("animal,trial,time_ms\n", "no rows"),
        ("", "no rows"),
    ],
)
def test_files_that_are_none_are_refused(tmp_path, text, message):
    (tmp_path / "spikes.csv").write_text(text)
    with pytest.raises(ValueError, match=message) as caught:
        read_spike_trains(tmp_path / "spikes.csv")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("trials", "kernel", "message"),
    [
        ([], 20, "trials is empty; give at least one animal"),
        ([[[1.0]], []], 20, r"trials\[1\] is empty; leave out an animal without trials"),
        ([[[1.0, np.nan]]], 20, r"trials\[0\]\[0\] is \[1.0, nan\]; give finite spike times"),
        ([[["a"]]], 20, r"trials\[0\]\[0\] is \['a'\]; give spike times in ms"),
        ([[[[1.0]]]], 20, r"trials\[0\]\[0\] is \[\[1.0\]\]; give finite spike times in ms, one axis"),
        ([[[1.0]]], 0, "kernel_ms is 0 ms; give a positive number"),
        ([[[1.0]]], np.nan, "kernel_ms is nan"),
    ],
)
def test_what_cannot_be_is_refused(trials, kernel, message, untyped):
    for make in (lambda: SpikeTrains(trials, kernel), lambda: spike_rate(trials, TIME, kernel)):
        with pytest.raises(ValueError, match=message):
            make()


def test_times_increase(untyped):
    with pytest.raises(ValueError, match=r"time\[1\] is 0; give times that increase"):
        spike_rate([[[1.0]]], np.array([0.0, 0.0]), 20)
