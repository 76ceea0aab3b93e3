"""The looming law beside a fit: known laws come back, and the lines of peak times are those of the curves."""

import dataclasses

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.fitting import Supplement
from lgmd2jax.fitting._law_fit import LawFit, check_approaches, compare_with_law, fit_law
from tests.fitting.fits import curve, fit_with

EYE = lgmd.Eye(rows=8, cols=12, degrees_per_pixel=10.0, fps=60.0)
SPEEDS = (5.0, 10.0, 20.0, 40.0)
TRUE = LawFit(4.4, -0.2, lgmd.Observation(baseline=6, gain=80, latency=55, smoothing=20))


def approach(l_over_v, fps=60.0):
    eye = lgmd.Eye(rows=8, cols=12, degrees_per_pixel=10.0, fps=fps)
    shown = lgmd.stimuli.looming(
        eye, l_over_v=l_over_v, contrast=-0.9, start_angle=2, stop_angle=80, start_ms=-1500, end_ms=400
    )
    return dataclasses.replace(shown, name=f"{l_over_v:g} ms")


def pairs_of(noise=0.0, speeds=SPEEDS):
    rng, pairs = np.random.default_rng(0), []
    for stimulus in map(approach, speeds):
        rate = TRUE.predict(stimulus)
        pairs.append((stimulus, [lgmd.Target("rate", rate + noise * rng.standard_normal(rate.size)).on(stimulus)]))
    return pairs


def curves_of(pairs, late=0.0):
    return [
        curve(
            condition=stimulus.name,
            channel="rate",
            frames=len(target.values),
            time=np.asarray(stimulus.time),
            target=target.values,
            hard=np.interp(np.asarray(stimulus.time) - late, np.asarray(stimulus.time), target.values),
        )
        for stimulus, (target,) in pairs
    ]


def test_the_law_is_eta_delayed_smoothed_and_scaled():
    stimulus, frame = approach(40.0, fps=240.0), 1000 / 240
    time, observation = np.asarray(stimulus.time), TRUE.observation
    angle = 2 * np.arctan2(40.0, -(time - float(observation.latency)))
    speed = np.gradient(angle, time)
    eta = np.where((angle >= np.radians(2)) & (angle < np.radians(80)), speed * np.exp(-4.4 * angle), 0)
    kernel = np.exp(-0.5 * (np.arange(-100, 101) * frame / 20) ** 2)
    expected = 6 + 80 * np.convolve(eta / eta.max(), kernel / kernel.sum(), mode="same")
    inside = slice(100, -100)
    np.testing.assert_allclose(TRUE.predict(stimulus)[inside], expected[inside], atol=0.2)


def test_a_known_law_comes_back():
    law = fit_law(pairs_of(), smoothing=20.0)
    assert law.alpha == pytest.approx(4.4, abs=0.02)
    assert law.exponent == pytest.approx(-0.2, abs=2e-3)
    for name in ("baseline", "gain", "latency"):
        assert float(getattr(law.observation, name)) == pytest.approx(float(getattr(TRUE.observation, name)), rel=5e-3)


def test_each_speed_is_predicted_from_the_others_and_lines_are_those_of_the_peaks():
    pairs = pairs_of(noise=0.2, speeds=SPEEDS[1:])
    law = compare_with_law(pairs, curves_of(pairs, late=1000 / 60), smoothing=20.0)
    assert all(r2 > 0.99 for r2 in (*law.r2.values(), *law.left_out.values()))
    assert set(law.peaks) == {stimulus.name for stimulus, _ in pairs}
    # The network's curves are the recorded ones, a frame later: the same slope.
    assert law.lines["network"].delta == pytest.approx(law.lines["recording"].delta + 1000 / 60, abs=0.01)
    assert law.lines["network"].alpha == pytest.approx(law.lines["recording"].alpha, abs=1e-3)
    # Smoothing shifts the peaks of a skewed curve back, least where it is broad: the slope is a little below alpha.
    assert 4.0 < law.lines["looming law"].alpha < 4.4
    assert law.lines["looming law"].r2 > 0.999


def test_the_report_and_the_file_tell_of_it():
    pairs = pairs_of(speeds=SPEEDS[1:])
    fit = fit_with(lgmd.Free(theta2=None), curves_of(pairs))
    law = compare_with_law(pairs, fit.curves, smoothing=20.0)
    report = fit.summary(Supplement(looming_law=law, left_out=dict.fromkeys(law.r2, 0.5)))
    assert "Beside the looming law" in report
    assert f"{law.lines['recording'].alpha:.2f} l/|v|" in report
    assert "0.500 and 1.000 (network, law)" in " ".join(report.split())
    assert "looming law" not in fit.summary()


def test_what_the_law_does_not_know_is_refused():
    still = lgmd.stimuli.luminance(EYE, level=20.0, background=200.0, start_ms=-100, end_ms=100)
    pairs = pairs_of()
    dark = [lgmd.Target("smp_adapted", target.values) for _, (target,) in pairs]
    check_approaches(pairs)
    for wrong, message in (
        ([(still, pairs[0][1])], "is not an approach"),
        ([(pairs[0][0], [dark[0]])], "is not an approach"),
        (pairs[:1], "one l/"),
    ):
        with pytest.raises(ValueError, match=message):
            check_approaches(wrong)
