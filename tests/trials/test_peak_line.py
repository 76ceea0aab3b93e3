"""The law of peak times from trials: a known line comes back, noise falls out, intervals are those of a bootstrap."""

import json

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.cli import main
from tests.trials.synthesis import ALPHA, DELTA_MS, NOISY, SPEEDS, WINDOW, recordings, write_tidy

ANGLE = np.degrees(2 * np.arctan(1 / ALPHA))


def trials_of(made):
    return lgmd.Trials(
        tuple(lgmd.Trial(it.animal, it.trial, {"l_over_v": it.l_over_v}, np.array(it.spikes), *WINDOW) for it in made)
    )


def clockwork(delta_ms, speeds=SPEEDS, alpha=ALPHA, animal="A"):
    """Trains without chance, dense about the peak; the line is exact."""
    bump = np.array([-40, -20, -8, -3, 0, 3, 8, 20, 40])
    return [
        lgmd.Trial(animal, str(number), {"l_over_v": speed}, delta_ms - alpha * speed + bump + shift, *WINDOW)
        for speed in speeds
        for number, shift in enumerate((-0.3, 0.0, 0.3))
    ]


@pytest.fixture(scope="module")
def law():
    return trials_of(recordings()).looming_law(resamples=300)


def test_a_known_line_comes_back(law):
    assert law.pooled.alpha.value == pytest.approx(ALPHA, abs=0.4)
    assert law.pooled.delta_ms.value == pytest.approx(DELTA_MS, abs=8)
    assert law.pooled.threshold_angle_deg.value == pytest.approx(ANGLE, abs=2.5)
    assert law.pooled.r2 > 0.99
    for times in (law.pooled, *law.animals.values()):
        pairs = ((times.alpha, ALPHA), (times.delta_ms, DELTA_MS), (times.threshold_angle_deg, ANGLE))
        for interval, truth in pairs:
            assert interval.low < interval.value < interval.high
            assert abs(interval.value - truth) < interval.high - interval.low  # four standard errors


def eta(time, speed):
    """Angular speed times an exponential of the angle, highest alpha l/|v| - delta before collision; it falls fast."""
    left = np.maximum(DELTA_MS - time, 1e-9)
    angle = 2 * np.arctan(speed / left)
    value = np.where(time < DELTA_MS, speed / (left**2 + speed**2) * np.exp(-ALPHA * angle), 0)
    return 4 + 150 * value / value.max()


def test_an_asymmetric_rate_is_timed_at_its_own_peak():
    """The rise takes three times as long as the fall. By a Gaussian of 20 ms fast approaches peak 12 ms early."""
    rng, time = np.random.default_rng(0), np.arange(-1499.5, 400)
    chance = {speed: eta(time, speed) / 1000 for speed in SPEEDS}
    trials = [
        lgmd.Trial(animal, str(i), {"l_over_v": speed}, np.repeat(time, rng.poisson(rate)), -1500, 400)
        for animal in "ABCDEFGH"
        for speed, rate in chance.items()
        for i in range(20)
    ]
    law, plain = (lgmd.Trials(tuple(trials)).looming_law(kernel, resamples=50) for kernel in (None, 20.0))
    assert law.pooled.alpha.value == pytest.approx(ALPHA, abs=0.4)
    assert law.pooled.delta_ms.value == pytest.approx(DELTA_MS, abs=8)
    truth = DELTA_MS - ALPHA * SPEEDS[0]
    assert law.pooled.peak_ms[SPEEDS[0]] == pytest.approx(truth, abs=8)
    assert plain.pooled.peak_ms[SPEEDS[0]] < truth - 10
    assert "sixth order" in law.summary()
    assert "a Gaussian of 20 ms" in plain.summary()


def test_noise_falls_out_and_is_named(law):
    assert NOISY not in law.animals
    assert [item.animal for item in law.excluded] == [NOISY]
    assert "base rate" in law.excluded[0].reason
    assert f"left out: {NOISY}: base rate" in law.summary()
    assert law.rule in law.summary()


def test_an_animal_whose_peaks_follow_no_line_is_named():
    peaks = {10.0: 100.0, 20.0: 160.0, 40.0: 90.0}  # ms before collision
    off = (it for speed, peak in peaks.items() for it in clockwork(ALPHA * speed - peak, (speed,), animal="B"))
    law = lgmd.Trials((*clockwork(20.0), *off)).looming_law(10.0, resamples=20)
    r2 = np.corrcoef(list(peaks), list(peaks.values()))[0, 1] ** 2
    assert law.animals["B"].r2 == pytest.approx(r2, abs=0.02)
    (line,) = (line for line in law.summary().splitlines() if line.startswith("hardly a line"))
    assert line.startswith(f"hardly a line: B: l/|v| explains {law.animals['B'].r2:.0%} of")


def test_without_chance_the_line_is_exact():
    law = lgmd.Trials(tuple(clockwork(20.0))).looming_law(10.0, resamples=20)
    assert law.pooled.alpha.value == pytest.approx(ALPHA, abs=0.01)
    assert law.pooled.delta_ms.value == pytest.approx(20.0, abs=0.5)
    assert law.pooled.r2 == pytest.approx(1, abs=1e-4)
    assert {round(peak + ALPHA * speed - 20.0) for speed, peak in law.pooled.peak_ms.items()} == {0}


def test_animals_that_were_shown_other_speeds_do_not_bend_the_common_line():
    """The delta of an animal is its own: the late one, which was shown slow approaches alone, does not flatten it."""
    trials = (*clockwork(10.0, (10.0, 20.0)), *clockwork(90.0, (40.0, 80.0), animal="B"))
    law = lgmd.Trials(trials).looming_law(10.0, resamples=20)
    assert law.pooled.alpha.value == pytest.approx(ALPHA, abs=0.02)
    assert law.pooled.delta_ms.value == pytest.approx(50.0, abs=0.7)
    assert law.pooled.r2 == pytest.approx(1, abs=1e-3)


def test_intervals_are_those_of_a_bootstrap_by_a_plain_loop():
    made = [it for it in recordings("A", trials=6, seed=3) if it.l_over_v in (20.0, 40.0)]
    law = trials_of(made).looming_law(20.0, resamples=2000, seed=1)
    rng, time, slopes = np.random.default_rng(9), np.arange(-450.0, 201.0), []
    smooth = {
        it.trial: sum((np.exp(-0.5 * ((time - spike) / 20) ** 2) for spike in it.spikes), np.zeros(time.shape))
        for it in made
    }
    for _ in range(500):
        peaks = []
        for speed in (20.0, 40.0):
            own = [it.trial for it in made if it.l_over_v == speed]
            within = time >= -10 * speed - 50
            total = sum(smooth[trial] for trial in rng.choice(own, len(own) - 1))
            peaks.append(time[np.where(within, total, -1).argmax()])
        slopes.append((peaks[0] - peaks[1]) / 20)
    expected = np.quantile(slopes, [0.025, 0.975])
    alpha = law.animals["A"].alpha
    np.testing.assert_allclose([alpha.low, alpha.high], expected, atol=0.15 * np.ptp(expected))


@pytest.mark.parametrize(
    ("trials", "reason"),
    [
        (clockwork(280.0, alpha=0.0), r"peak at \d+ ms, not within"),
        ([lgmd.Trial("A", "0", {"l_over_v": speed}, np.zeros(0), *WINDOW) for speed in SPEEDS], "peak 0.0 spikes/s"),
        (clockwork(20.0, (20.0,)), r"one l/\|v\| is left, 20 ms"),
    ],
)
def test_what_is_no_response_to_an_approach_falls_out(trials, reason):
    with pytest.raises(ValueError, match=f"no animal has a line.*{reason}"):
        lgmd.Trials(tuple(trials)).looming_law()


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"kernel_ms": 0.0}, "kernel_ms is 0"),
        ({"kernel_ms": 0.02}, "kernel_ms is 0.02; give the s.d. of a Gaussian in ms"),
        ({"kernel_ms": 1e9}, "kernel_ms is 1e\\+09"),
        ({"kernel_ms": float("nan")}, "kernel_ms is nan"),
        ({"resamples": 1}, "resamples is 1"),
        ({"seed": -1}, "seed is -1; give 0 or more"),
    ],
)
def test_settings_that_cannot_be_are_refused(settings, words):
    with pytest.raises(ValueError, match=words):
        lgmd.Trials(tuple(clockwork(20.0))).looming_law(**settings)


def test_trials_without_l_over_v_are_refused_with_the_cure():
    trials = [lgmd.Trial("A", str(i), {}, np.array([0.0]), *WINDOW) for i in range(2)]
    with pytest.raises(ValueError, match="--l-over-v"):
        lgmd.Trials(tuple(trials)).looming_law()


def test_the_command_prints_and_writes_the_same(tmp_path, capsys):
    write_tidy(tmp_path / "spikes.csv", recordings("AD", trials=4))
    law, figure = tmp_path / "law.json", tmp_path / "law.svg"
    arguments = [
        "looming",
        str(tmp_path / "spikes.csv"),
        "--json",
        str(law),
        "--figure",
        str(figure),
        "--resamples",
        "50",
    ]
    assert main(arguments) == 0
    content = json.loads(law.read_text(encoding="utf-8"))
    assert set(content["animals"]) == {"A"}
    assert [item["animal"] for item in content["excluded"]] == [NOISY]
    for line in (content["pooled"], *content["animals"].values()):
        for key in ("alpha", "delta_ms", "threshold_angle_deg"):
            assert line[key]["low"] <= line[key]["value"] <= line[key]["high"]
    printed = capsys.readouterr().out
    assert f"{content['pooled']['alpha']['value']:.3g}" in printed
    assert "base rate" in printed
    assert figure.read_text(encoding="utf-8").startswith("<?xml")
