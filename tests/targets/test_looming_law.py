"""The looming law against its closed form (Gabbiani, Krapp & Laurent 1999), on stimuli as they are rendered."""

import dataclasses

import numpy as np
import pytest

from lgmd2jax import stimuli
from lgmd2jax._eye import Eye
from lgmd2jax._targets.looming_law import LoomingLaw

EYE = Eye(rows=3, cols=3, degrees_per_pixel=10.0, fps=2000.0)


def looming(l_over_v=20.0, start_ms=-600.0, end_ms=100.0, **changes):
    return stimuli.looming(EYE, l_over_v=l_over_v, contrast=-0.9, start_ms=start_ms, end_ms=end_ms, **changes)


def crossing(time, curve, level):
    """The first time at which the curve rises through a level, and the last at which it falls."""
    above = np.flatnonzero(curve >= level)
    rise, fall = above[0], above[-1]
    rises = np.interp(level, curve[rise - 1 : rise + 1], time[rise - 1 : rise + 1])
    falls = np.interp(-level, -curve[fall : fall + 2], time[fall : fall + 2])
    return rises, falls


@pytest.mark.parametrize("l_over_v", [5.0, 20.0, 50.0])
@pytest.mark.parametrize(("alpha", "delta"), [(4.4, 18.7), (2.75, 35.0), (7.6, 0.0)])
def test_it_peaks_where_theory_says(l_over_v, alpha, delta):
    stimulus = looming(l_over_v)
    target = LoomingLaw(peak=0.3, alpha=alpha, delta=delta).on(stimulus)
    time = np.asarray(stimulus.time)
    peak = time[np.argmax(target.values)]
    assert abs(-peak - (alpha * l_over_v - delta)) <= 0.5
    angle = np.interp(peak - delta, time, stimulus.courses["full_angle_deg"])
    np.testing.assert_allclose(angle, 2 * np.degrees(np.arctan(1 / alpha)), rtol=0.5 / (alpha * l_over_v))
    np.testing.assert_allclose(target.values.max(), 0.8, atol=0.3 * 1e-4 * (20 / l_over_v) ** 2)


def test_its_width_and_skew_are_those_of_eta():
    """At alpha 4.4: FWHM 9.65 l/|v| and rise:fall 3.05 (docs: biology). The early end lies before 2 degrees."""
    stimulus = looming(20.0, start_ms=-900.0, start_angle=0.5)
    curve = LoomingLaw(peak=1.0, channel="spikes").on(stimulus).values
    time = np.asarray(stimulus.time)
    rises, falls = crossing(time, curve, 0.5)
    peak = -(4.4 * 20 - 18.7)
    np.testing.assert_allclose((falls - rises) / 20, 9.65, atol=0.01)
    np.testing.assert_allclose((peak - rises) / (falls - peak), 3.05, atol=0.01)


def test_it_is_the_product_of_speed_and_exponential_angle():
    """Angle and speed from the rendered course, by differences, instead of the closed form."""
    delta = 20.0
    stimulus = looming(20.0)
    time, angle = np.asarray(stimulus.time), np.radians(stimulus.courses["full_angle_deg"])
    eta = np.gradient(angle, time) * np.exp(-4.4 * angle)
    late = np.interp(time - delta, time, eta)
    target = LoomingLaw(peak=0.3, delta=delta).on(stimulus).values - 0.5
    stop = -20 / np.tan(np.radians(40)) + delta
    smooth = (np.abs(time - stop) > 2) & (time > time[0] + delta)
    np.testing.assert_allclose(target[smooth], 0.3 * late[smooth] / eta.max(), atol=1e-4)


@pytest.mark.parametrize("exponent", [0.0, -0.18, -1.0])
def test_the_amplitude_goes_as_a_power(exponent):
    law = LoomingLaw(peak=0.2, exponent=exponent)
    for l_over_v in (20.0, 40.0, 80.0):
        height = law.on(looming(l_over_v)).values.max() - 0.5
        np.testing.assert_allclose(height, 0.2 * (l_over_v / 40) ** exponent, rtol=1e-4)


@pytest.mark.parametrize("stop", [40.0, 60.0, 80.0])
def test_it_ends_delta_after_the_object_has_stopped(stop):
    stimulus = looming(20.0, stop_angle=stop)
    values, time = LoomingLaw(peak=0.3).on(stimulus).values, np.asarray(stimulus.time)
    end = -20 / np.tan(np.radians(stop / 2)) + 18.7
    assert np.all(values[time > end + 0.5] == 0.5)
    assert np.all(values[(time > -400) & (time < end - 0.5)] > 0.5)


def test_it_begins_delta_after_the_object_has_started():
    stimulus = looming(20.0, start_angle=10.0)
    values, time = LoomingLaw(peak=0.3).on(stimulus).values, np.asarray(stimulus.time)
    begin = -20 / np.tan(np.radians(5)) + 18.7
    assert np.all(values[time < begin - 0.5] == 0.5)
    assert values[time > begin + 0.5][0] > 0.51


@pytest.mark.parametrize(("channel", "rest", "base"), [("smp", None, 0.5), ("spikes", None, 0.0), ("rate", 4.0, 4.0)])
def test_it_stands_on_the_rest_of_its_channel(channel, rest, base):
    target = LoomingLaw(peak=0.3, channel=channel, rest=rest).on(looming(5.0))
    assert target.channel == channel
    assert target.values[0] == base
    assert target.values[-1] == base


@pytest.mark.parametrize(
    "other",
    [
        stimuli.receding(EYE, l_over_v=20.0, contrast=-0.9, start_ms=-50.0, end_ms=300.0),
        looming(20.0, deviation=30.0),
        dataclasses.replace(looming(20.0), time=looming(20.0).time + 5),
    ],
    ids=["receding", "passing by", "another clock"],
)
def test_another_course_is_refused(other):
    with pytest.raises(ValueError, match="one of an approach straight to the eye, of which the full angle at"):
        LoomingLaw(peak=0.3).on(other)


def test_a_stimulus_without_the_speed_is_refused():
    other = stimuli.translating(EYE, contrast=-0.9, size=10.0, speed=60.0, start_ms=-50.0, end_ms=50.0)
    with pytest.raises(ValueError, match="needs a looming stimulus with l_over_v; this one has no 'l_over_v'"):
        LoomingLaw(peak=0.3).on(other)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"peak": 0}, "peak is 0; give a positive number"),
        ({"alpha": -1}, "alpha is -1; give a positive number"),
        ({"delta": np.inf}, "delta is inf; give a finite number"),
        ({"exponent": np.nan}, "exponent is nan"),
        ({"channel": "smp_adaptd"}, "channel is 'smp_adaptd'; choose 'smp_adapted'"),
        ({"channel": "rate"}, "rest is missing; a rate has no resting value of its own"),
        ({"rest": np.nan}, "rest is nan"),
    ],
)
def test_what_cannot_be_is_refused(change, message, untyped):
    with pytest.raises(ValueError, match=message):
        LoomingLaw(**{"peak": 0.3} | change)
