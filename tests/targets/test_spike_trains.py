"""Rates from spike times: the kernel, the mean over animals, its standard error."""

import math
import time
import tracemalloc
from typing import Any

import jax.numpy as jnp
import neo
import numpy as np
import pandas as pd
import pytest
import quantities as pq
from scipy.ndimage import gaussian_filter1d

from lgmd2jax._targets.csv_files import read_spike_trains
from lgmd2jax._targets.gaussian_sum import gaussian_sum
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
    means, between, poissons = [], [], []
    for moment in TIME:
        grid = np.linspace(start, end, 20_001)
        kernel = np.exp(-((moment - grid) ** 2) / (2 * 25.0**2))
        area, square = np.trapezoid(kernel, grid) / 1000, np.trapezoid(kernel**2, grid) / 1000
        animals = []
        for animal in trials:
            rates = [sum(math.exp(-((moment - s) ** 2) / (2 * 25.0**2)) for s in trial) / area for trial in animal]
            animals.append(sum(rates) / len(rates))
        mean = sum(animals) / 3
        means.append(mean)
        between.append(sum((animal - mean) ** 2 for animal in animals) / 2 / 3)
        # A Poisson process of r spikes/s, smoothed by k/area, has the variance r (integral of k^2)/area^2.
        per_rate = square / area**2 * (1 / 2 + 1 / 3 + 1 / 4) / 9
        poissons.append((mean + 0.5 * per_rate) * per_rate)
    np.testing.assert_allclose(target.values, means, rtol=1e-6)
    dispersion = max(1, sum(between) / sum(poissons))
    expected = [max((2 * b + 4 * dispersion * p) / 6, p) for b, p in zip(between, poissons, strict=True)]
    assert target.sem is not None
    np.testing.assert_allclose(target.sem, np.sqrt(expected), rtol=1e-6)


def peri_event(rng, animals, trials):
    """Trains of cells that are silent but for a response of 80 spikes/s around 0, of another gain in each animal."""
    made = []
    for gain in rng.uniform(0.7, 1.3, animals):
        count = rng.poisson(80 * gain * 0.3, trials)
        made.append([rng.uniform(-150, 150, n) for n in count])
    return made


def test_few_animals_leave_no_frame_with_all_the_weight():
    """Silent frames of three animals: the spread over animals is 0 there and tells nothing."""
    for seed in range(10):
        target = spike_rate(peri_event(np.random.default_rng(seed), 3, 10), TIME, 20.0)
        assert target.sem is not None
        weight = 1 / np.square(target.sem)
        # No spike in 30 trials of 71 ms: half a spike in that time, and its error, is what can be said.
        exposure = 30 * 2 * math.sqrt(math.pi) * 0.020
        np.testing.assert_array_less(0.99 * math.sqrt(0.5) / exposure, target.sem)
        silent = np.abs(TIME) > 250
        assert weight.max() <= 1.01 * np.median(weight[silent])
        assert np.sort(weight)[-5:].sum() < 0.15 * weight.sum()


def test_the_error_is_right_in_the_mean_and_three_animals_are_enough_to_use_it():
    """Of many experiments, the deviation from the true rate in units of the stated error has the s.d. 1."""
    rng = np.random.default_rng(4)
    inside = np.abs(TIME) < 100
    scores, plain = [], []
    for _ in range(150):
        trials = [[poisson(rng, 60.0, -400, 400) for _ in range(5)] for _ in range(3)]
        target = spike_rate(trials, TIME, 20.0)
        assert target.sem is not None
        scores.append((target.values[inside] - 60)[::7] / target.sem[inside][::7])
        rates = np.stack([spike_rate([animal], TIME, 20.0).values for animal in trials])
        plain.append((rates.mean(axis=0) - 60)[inside][::7] / (rates.std(axis=0, ddof=1) / math.sqrt(3))[inside][::7])
    assert np.std(scores) == pytest.approx(1, abs=0.1)
    assert np.max(np.abs(scores)) < 5
    assert np.max(np.abs(plain)) > 15  # of the plain s.e.m., which this replaces


def test_with_many_animals_it_is_the_plain_error():
    trials = peri_event(np.random.default_rng(0), 400, 3)
    target = spike_rate(trials, TIME, 20.0)
    rates = np.stack([spike_rate([animal], TIME, 20.0).values for animal in trials])
    strong = target.values > 40
    assert target.sem is not None
    np.testing.assert_allclose(target.sem[strong], (rates.std(axis=0, ddof=1) / 20)[strong], rtol=0.02)
    assert "s.e.m. over 400 animals" in target.sem_rule
    assert target.on(STIMULUS).rules[-1] == target.sem_rule


def test_silent_animals_can_be_fitted():
    """No spike in 6 trials: the error of half a spike in the time that they cover, by Poisson's variance."""
    target = SpikeTrains([[[], [], []], [[], [], []]]).on(STIMULUS)
    exposure = 6 * 2 * math.sqrt(math.pi) * 0.020
    np.testing.assert_array_equal(target.values, 0)
    np.testing.assert_allclose(1 / target.scale[20:60], math.sqrt(0.5) / exposure, rtol=1e-6)
    assert target.has_error


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
    np.testing.assert_allclose(target.thinning, 2 * math.sqrt(math.pi) * 30 / 10)


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
        ("animal,trial,when\nA,1,3\n", r"spikes.csv: no column is named like a time; name it by time = '...', one of"),
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
        ([[["a"]]], 20, r"trials\[0\]\[0\] is \['a'\]; give times in ms"),
        ([[[[1.0]]]], 20, r"trials\[0\]\[0\] is \[\[1.0\]\]; give finite spike times in ms, one axis"),
        ([10.0, 20.0], 20, r"trials\[0\] is 10.0; give an animal's trials as a list, as \[\[\[10, 20\]\]\]"),
        ([[10.0, 20.0]], 20, r"trials\[0\]\[0\] is 10.0; give finite spike times in ms, one axis"),
        (np.array([10.0, 20.0]), 20, r"trials\[0\] is"),
        (10.0, 20, "trials is 10.0; give for each animal a list of trials"),
        (None, 20, "trials is None; give for each animal"),
        ("spikes.csv", 20, "trials is 'spikes.csv'; give for each animal"),
        ({"A": [[1.0]]}, 20, "trials is {'A'.*; give for each animal"),
        ([{1.0, 2.0}], 20, r"trials\[0\] is {1.0, 2.0}; give an animal's trials as a list"),
        ([[{1.0}]], 20, r"trials\[0\]\[0\] is {1.0}; give times in ms"),
        ([[[1.0] * pq.mV]], 20, r"trials\[0\]\[0\] has another unit than ms"),
        ([[np.arange(40) % 9 == 0]], 20, r"trials\[0\]\[0\] holds 40 times 0 or 1, as a raster does; give the spikes'"),
        ([[[0, 0, 1, 0, 1]]], 20, r"trials\[0\]\[0\] holds 5 times 0 or 1, as a raster does"),
        ([[np.array([1.0, 2.0 + 1j])]], 20, r"trials\[0\]\[0\] is array.*; give times in ms"),
        ([[[1.0]]], "20", "kernel_ms is '20' ms; give a positive number"),
        ([[[1.0]]], 0, "kernel_ms is 0 ms; give a positive number"),
        ([[[1.0]]], np.nan, "kernel_ms is nan"),
    ],
)
def test_what_cannot_be_is_refused(trials, kernel, message, untyped):
    for make in (lambda: SpikeTrains(trials, kernel), lambda: spike_rate(trials, TIME, kernel)):
        with pytest.raises(ValueError, match=message):
            make()


SPIKES = np.random.default_rng(5).uniform(-390, 390, 60)


@pytest.mark.parametrize("way", ["neo", "seconds of quantities", "pandas", "iterators"])
def test_spike_times_with_a_unit_are_converted(way, untyped):
    spikes = np.sort(SPIKES)
    converted = {
        "neo": lambda: [[neo.SpikeTrain(spikes / 1000 * pq.s, t_start=-1 * pq.s, t_stop=1 * pq.s)]],
        "seconds of quantities": lambda: [[spikes / 1000 * pq.s]],
        "pandas": lambda: [[pd.Series(pd.to_timedelta(spikes, unit="ms"))]],
        "iterators": lambda: (iter([spikes]) for _ in range(1)),
    }[way]
    kernel: Any = 0.02 * pq.s
    trains = SpikeTrains(converted(), kernel)
    for _ in range(2):
        np.testing.assert_allclose(
            trains.on(STIMULUS).values, spike_rate([[spikes]], TIME, 20.0).values, rtol=1e-5, atol=1e-5
        )


@pytest.mark.parametrize(
    ("spikes", "message"),
    [
        (SPIKES / 1000 + 30, "lie at 29.6.* ms and the stimulus at -400 to 400 ms: they look like seconds"),
        (
            SPIKES / 1000 + 3000,
            "lie at 2999.6.* ms and the stimulus at -400 to 400 ms: they look like those of another",
        ),
        (SPIKES / 1000 + 0.5, "they look like seconds; give them in ms"),
        (SPIKES * 1000, "they look like microseconds; give them in ms"),
        (SPIKES + 1.2e6, "they look like those of another clock; subtract the time of the event"),
        ([0.01, 0.02, 0.5], "they look like seconds"),
    ],
)
def test_spikes_that_cannot_belong_to_the_stimulus_are_told(spikes, message):
    some = np.any(np.abs(spikes) < 400)
    with pytest.warns(UserWarning, match=message) if some else pytest.raises(ValueError, match=message):
        SpikeTrains([[spikes]]).on(STIMULUS)


@pytest.mark.parametrize("spikes", [SPIKES, SPIKES[:2] / 1000, [-3.0, 0.0, 4.0], [], EDGES, [5.0, 8.0, 30.0]])
def test_spikes_that_can_belong_to_it_pass(spikes):
    SpikeTrains([[spikes]]).on(STIMULUS)


def test_a_kernel_in_seconds_is_refused():
    with pytest.raises(ValueError, match=r"kernel_ms is 0.02 ms and the samples are 10 ms apart, so that most spikes"):
        SpikeTrains([[SPIKES]], 0.02).on(STIMULUS)


def test_the_sum_of_gaussians_is_the_plain_sum():
    rng = np.random.default_rng(6)
    for places in (TIME, np.sort(rng.uniform(-3000, 3000, 50)), np.array([7.0])):
        for s in (0.7, 20.0, 300.0):
            centres = rng.uniform(-1500, 1500, 4000)
            plain = np.exp(-0.5 * np.square((places[:, None] - centres) / s)).sum(axis=1)
            np.testing.assert_allclose(gaussian_sum(centres, places, s), plain, rtol=1e-12, atol=1e-10)


def test_a_million_spikes_take_a_second_and_little_memory():
    """As a histogram of 0.1 ms behind scipy's Gaussian filter, which takes bins for spikes."""
    spikes = np.random.default_rng(7).normal(0, 150, 1_000_000)
    tracemalloc.start()
    began = time.perf_counter()
    target = spike_rate([[spikes]], TIME, 20.0)
    seconds, (_, most) = time.perf_counter() - began, tracemalloc.get_traced_memory()
    tracemalloc.stop()
    histogram, edges = np.histogram(spikes, np.arange(-1500, 1500.05, 0.1))
    smooth = gaussian_filter1d(histogram / 1e-4, 200.0, truncate=8)
    inside = np.interp(TIME, (edges[1:] + edges[:-1]) / 2, smooth)
    np.testing.assert_allclose(target.values, inside, rtol=1e-4)
    assert seconds < 2  # tracing of memory included
    assert most < 2e8


def test_times_increase(untyped):
    with pytest.raises(ValueError, match=r"time\[1\] is 0; give times that increase"):
        spike_rate([[[1.0]]], np.array([0.0, 0.0]), 20)
