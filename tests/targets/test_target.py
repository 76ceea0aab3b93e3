"""Targets on the frames of a stimulus: what is interpolated, what counts, and what is refused."""

import jax.numpy as jnp
import numpy as np
import pytest
import quantities as pq

from lgmd2jax._targets.target import AnyTarget, Target
from lgmd2jax._targets.weighted import Weighted
from lgmd2jax.stimuli import Stimulus

FRAMES = np.arange(-5, 6) * 10.0
STIMULUS = Stimulus(jnp.zeros((11, 3, 3)), 100.0, jnp.asarray(FRAMES))
CURVE = np.sin(FRAMES / 20)


def test_a_value_a_frame():
    target = Target("smp", CURVE, weight=4).on(STIMULUS)
    np.testing.assert_array_equal(target.values, CURVE)
    np.testing.assert_array_equal(target.time, FRAMES)
    np.testing.assert_array_equal(target.scale, np.full(11, 2.0))
    assert not target.has_error
    np.testing.assert_array_equal(target.thinning, 1)


def test_what_stands_on_the_frames_stays_there():
    once = Target("rate", CURVE, time=FRAMES, error=CURVE + 2, sem=CURVE + 3, weight=FRAMES > 0, correlation_ms=71)
    twice = once.on(STIMULUS).on(STIMULUS)
    for name in ("values", "time", "error", "sem", "weight"):
        np.testing.assert_array_equal(getattr(twice, name), getattr(once, name))


def test_a_target_is_one_of_its_own_kind():
    assert isinstance(Target("smp", CURVE), AnyTarget)
    assert isinstance(Weighted(Target("smp", CURVE)), AnyTarget)


@pytest.mark.parametrize("kind", [list, tuple, jnp.asarray, np.float32, np.asarray])
def test_any_array_will_do(kind):
    np.testing.assert_allclose(Target("smp", kind(CURVE)).on(STIMULUS).values, CURVE, rtol=1e-6)


def test_interpolation_is_linear_and_weighs_nothing_outside():
    """Values closer than the frames: all frames that they cover count, with what lies between two values."""
    time = np.arange(-33.0, 31.0, 7.0)
    values, sem = np.square(time), 1 + np.abs(time)
    on_frames = Target("rate", values, time, sem=sem, weight=4, interpolate=True).on(STIMULUS)
    inside = (FRAMES >= -33) & (FRAMES <= 30)
    np.testing.assert_array_equal(on_frames.weight > 0, inside)
    # By hand: -30 lies 3 of 7 ms behind -33.
    np.testing.assert_allclose(on_frames.values[2], (4 * 33**2 + 3 * 26**2) / 7)
    np.testing.assert_allclose(on_frames.values[inside], np.interp(FRAMES[inside], time, values))
    np.testing.assert_allclose(on_frames.scale[inside], 2 / np.interp(FRAMES[inside], time, sem))
    assert np.all(on_frames.scale[~inside] == 0)


def test_values_further_apart_than_the_frames_are_carried_to_the_nearest():
    """Each is one sample; a parabola through its neighbours, which np.gradient takes, is met in the middle."""
    time = np.array([-33.0, -12.0, 4.0, 31.0])
    bent = lambda t: 3 + t / 10 + np.square(t) / 50  # noqa: E731
    target = Target("rate", bent(time), time, sem=[0.1, 0.5, 0.2, 0.8], weight=[4, 4, 9, 9], interpolate=True)
    on_frames = target.on(STIMULUS)
    np.testing.assert_array_equal(FRAMES[on_frames.weight > 0], [-30, -10, 0, 30])
    # What the slope misses is the curvature over the few ms to the frame: (t - frame)^2/50.
    np.testing.assert_allclose(on_frames.values[[4, 5]], [bent(-10) - 4 / 50, bent(0) - 16 / 50])
    ends = [bent(-33) + 3 * (bent(-12) - bent(-33)) / 21, bent(31) - (bent(31) - bent(4)) / 27]
    np.testing.assert_allclose(on_frames.values[[2, 8]], ends)
    np.testing.assert_allclose(on_frames.scale[5], np.sqrt(4 + 5 * 12 / 16) / np.interp(0, time, [0.1, 0.5, 0.2, 0.8]))


def test_nothing_is_known_beside_a_value_that_does_not_count():
    spoilt = [1.0, 1e6, 3, 4]
    on_frames = Target("rate", spoilt, [-40.0, -15, 10, 35], weight=[1, 0, 1, 1], interpolate=True).on(STIMULUS)
    np.testing.assert_array_equal(FRAMES[on_frames.weight > 0], [-40, 10, 30])
    assert np.max(on_frames.values[on_frames.weight > 0]) < 4


@pytest.mark.parametrize("spacing", [2.0, 7.0, 10.0, 13.0, 25.0, 100.0])
def test_there_are_no_more_samples_than_values_and_than_frames(spacing):
    """Values at any spacing, at any place between the frames: as many frames count as there are values for them."""
    frames = np.arange(-1000, 1001) * 10.0
    stimulus = Stimulus(jnp.zeros((2001, 3, 3)), 100.0, jnp.asarray(frames))
    for shift in (0.0, 3.3, 5.0):
        time = np.arange(-10_000.0, 10_000.0, spacing) + shift
        target = Target("rate", np.sin(time / 500), time, interpolate=True).on(stimulus)
        counted = np.count_nonzero(target.weight)
        inside = np.count_nonzero((frames >= time[0]) & (frames <= time[-1]))
        np.testing.assert_array_equal(target.thinning, 1)
        assert abs(counted - min(len(time), inside)) <= 1
        np.testing.assert_allclose(target.values[target.weight > 0], np.sin(frames / 500)[target.weight > 0], atol=6e-3)


def test_nine_values_a_hundred_ms_apart_are_nine_samples():
    frames = np.arange(81) * 10.0
    stimulus = Stimulus(jnp.zeros((81, 3, 3)), 100.0, jnp.asarray(frames))
    target = Target("rate", np.arange(9.0), np.arange(9) * 100.0, interpolate=True)
    assert np.count_nonzero(target.on(stimulus).weight) == 9
    assert target.on(stimulus).rules == (
        "values further apart than the frames: each is one sample, at the frame nearest to it",
    )
    # Behind a kernel of 71 ms such values are nearly independent; of every frame there were 7.1 to a sample.
    correlated = Target("rate", np.arange(9.0), np.arange(9) * 100.0, interpolate=True, correlation_ms=71)
    np.testing.assert_array_equal(correlated.on(stimulus).thinning, 1)
    every = Target("rate", np.arange(81.0), correlation_ms=71).on(stimulus)
    np.testing.assert_allclose(every.thinning, 7.1)


def test_an_error_goes_before_the_recorded_one():
    sem = np.linspace(1, 2, 11)
    assert Target("rate", CURVE, sem=sem).has_error
    assert Target("rate", CURVE, error=3).has_error
    np.testing.assert_allclose(Target("rate", CURVE, sem=sem, weight=4).scale, 2 / sem)
    np.testing.assert_allclose(Target("rate", CURVE, sem=sem, error=3.0, weight=4).on(STIMULUS).scale, 2 / 3)
    np.testing.assert_allclose(Target("rate", CURVE, error=sem).on(STIMULUS).scale, 1 / sem)


def test_a_standard_error_of_zero_is_an_accident_and_carries_no_fit():
    sem = np.where(FRAMES >= 20, 0.0, 1.0)
    target = Target("rate", CURVE, sem=sem).on(STIMULUS)
    usual = np.sqrt(7 / 11)
    np.testing.assert_allclose(target.scale, 1 / np.maximum(sem, 0.1 * usual))
    np.testing.assert_array_equal(target.sem, sem)
    assert target.rules == ("standard errors below 0.1 of their r.m.s. count as that",)
    np.testing.assert_array_equal(Target("rate", CURVE, sem=sem, weight=sem).scale, sem)
    np.testing.assert_array_equal(Target("rate", CURVE, sem=sem, error=1.0).scale, 1)
    assert Target("rate", CURVE, sem=sem, error=1.0).rules == ()


def test_standard_errors_of_zero_throughout_tell_nothing():
    with pytest.raises(ValueError, match="sem is 0 throughout; give an error that replaces it"):
        _ = Target("rate", CURVE, sem=np.zeros(11)).on(STIMULUS).scale
    assert np.all(Target("rate", CURVE, sem=np.zeros(11), weight=0).on(STIMULUS).scale == 0)


def test_thinning_counts_the_frames_of_a_sample():
    np.testing.assert_allclose(Target("rate", CURVE, correlation_ms=71).on(STIMULUS).thinning, 7.1)
    np.testing.assert_array_equal(Target("rate", CURVE, correlation_ms=4).on(STIMULUS).thinning, 1)


def test_values_of_uneven_spacing_count_by_their_own_neighbours():
    """Far apart each is a sample; in a run of close ones a span makes one; beside a gap half of each."""
    frames = np.arange(-600.0, 201.0, 10.0)
    stimulus = Stimulus(jnp.zeros((frames.size, 3, 3)), 100.0, jnp.asarray(frames))

    def samples(time):
        target = Target("rate", np.ones(len(time)), time, interpolate=True, correlation_ms=100).on(stimulus)
        return np.sum((target.weight > 0) / target.thinning)

    far, close = np.arange(-600.0, 0.0, 100.0), np.arange(0.0, 201.0, 10.0)
    assert samples(far) == 6
    assert samples(close) == pytest.approx(2.1)
    assert samples(np.concatenate([far, close])) == pytest.approx(6 + 2.1 + (100 - 10) / 2 / 100)
    assert samples([0.0]) == 1


def test_rounded_times_are_those_of_the_frames():
    time = np.arange(-72, 26) * 1000 / 60
    stimulus = Stimulus(jnp.zeros((98, 3, 3)), 60.0, jnp.asarray(time))
    rounded = [float(f"{moment:.6g}") for moment in time]
    np.testing.assert_array_equal(Target("smp", time, rounded).on(stimulus).time, time)


@pytest.mark.parametrize(
    ("time", "message"),
    [
        (FRAMES[1:], "the target has 10 values and the stimulus 11 frames"),
        (FRAMES + 0.5, "has a value at -49.5 ms where the stimulus has a frame at -50 ms; set interpolate = true"),
        (FRAMES * 2, "has a value at -100 ms where the stimulus has a frame at -50 ms"),
    ],
)
def test_another_grid_is_refused_unless_it_may_be_interpolated(time, message):
    with pytest.raises(ValueError, match=message):
        Target("smp", np.ones(time.size), time).on(STIMULUS)
    np.testing.assert_array_equal(Target("smp", np.ones(time.size), time, interpolate=True).on(STIMULUS).values, 1)


def test_another_length_is_refused():
    with pytest.raises(ValueError, match="10 values and the stimulus 11 frames; give one a frame, or times"):
        Target("smp", CURVE[1:], interpolate=True).on(STIMULUS)


LONG = np.arange(-100, 41) * 10.0
WINDOW = Stimulus(jnp.zeros((141, 3, 3)), 100.0, jnp.asarray(LONG))


@pytest.mark.parametrize(
    ("factor", "shift", "message"),
    [
        (
            1e-3,
            0,
            "target's times lie at -1 to 0.4 ms and the stimulus at -1000 to 400 ms: they look like seconds",
        ),
        (1e3, 0, "the target covers -1e.06 to 400000 ms: .* look like microseconds; give them in ms"),
        (1, 9e6, "covers 8.999e.06 to .* look like those of another clock; subtract the time of the event"),
        (1e-3, 9e3, "covers 8999 to 9000.4 ms: no frame of the stimulus"),
    ],
)
def test_times_that_cannot_be_those_of_the_stimulus_are_refused(factor, shift, message):
    target = Target("rate", np.ones(141), factor * LONG + shift, interpolate=True)
    with pytest.raises(ValueError, match=message) as caught:
        target.on(WINDOW)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("time", [np.arange(-9e5, 9e5, 20.0), np.linspace(-5, 25, 301), np.array([0.0, 0.5])])
def test_long_fine_and_few_times_are_taken(time):
    assert np.any(Target("rate", np.ones(time.size), time, interpolate=True).on(WINDOW).weight)


def test_times_and_rates_with_a_unit_are_converted(untyped):
    plain = Target("rate", CURVE, FRAMES, sem=np.abs(CURVE) + 1, correlation_ms=71)
    other = Target(
        "rate",
        CURVE * pq.Hz,
        time=FRAMES / 1000 * pq.s,
        sem=(np.abs(CURVE) + 1) / 1000 * pq.kHz,
        correlation_ms=0.071 * pq.s,
    )
    for name in ("values", "time", "sem", "correlation_ms"):
        np.testing.assert_allclose(getattr(other, name), getattr(plain, name), rtol=1e-12)
    with pytest.raises(ValueError, match="time has another unit than ms"):
        Target("rate", CURVE, time=FRAMES * pq.mV)
    with pytest.raises(ValueError, match=r"values\[5\] is nan; give a finite number"):
        Target("rate", np.ma.masked_where(FRAMES == 0, CURVE))


def test_a_target_beside_the_stimulus_is_refused():
    with pytest.raises(ValueError, match="covers 60 to 160 ms: no frame of the stimulus, -50 to 50 ms"):
        Target("smp", CURVE, FRAMES + 110, interpolate=True).on(STIMULUS)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"channel": "spike"}, "channel is 'spike'; choose 'spikes'"),
        ({"values": [[1.0]]}, r"values has shape \(1, 1\)"),
        ({"values": []}, r"values has shape \(0,\)"),
        ({"values": ["a"]}, r"values is \['a'\]; give numbers"),
        ({"values": np.where(FRAMES == 0, np.nan, 1)}, r"values\[5\] is nan; give a finite number"),
        ({"time": FRAMES[1:]}, r"time has shape \(10,\) and values \(11,\)"),
        ({"time": -FRAMES}, r"time\[1\] is 40; give times that increase"),
        ({"time": np.zeros(11)}, "give times that increase"),
        ({"sem": -np.ones(11)}, r"sem\[0\] is -1; give 0 or more"),
        ({"sem": np.ones(3)}, r"sem has shape \(3,\)"),
        ({"error": 0}, "error is 0; give a positive number"),
        ({"error": -1}, "error is -1; give a positive number"),
        ({"error": np.where(FRAMES == 0, -2.0, 1)}, r"error\[5\] is -2"),
        ({"error": np.inf}, "error is inf"),
        ({"weight": -1}, "weight is -1; give 0 or more"),
        ({"weight": np.nan}, "weight is nan"),
        ({"weight": None}, "weight is nan"),
        ({"correlation_ms": -1}, "correlation_ms is -1 ms; give 0 or more"),
        ({"correlation_ms": np.nan}, "correlation_ms is nan"),
    ],
)
def test_what_cannot_be_is_refused(change, message, untyped):
    with pytest.raises(ValueError, match=message) as caught:
        Target(**{"channel": "smp", "values": CURVE} | change)
    assert "\n" not in str(caught.value)


def test_a_window_counts_with_its_ends():
    target = Weighted(Target("smp", CURVE, weight=2), weight=8, from_ms=-10, until_ms=20).on(STIMULUS)
    np.testing.assert_array_equal(target.scale, np.where((FRAMES >= -10) & (FRAMES <= 20), 4.0, 0.0))
    half = Weighted(Target("smp", CURVE), from_ms=30).on(STIMULUS)
    np.testing.assert_array_equal(FRAMES[half.weight > 0], [30, 40, 50])


def test_a_weighting_takes_the_place_of_the_targets_own():
    own = Target("rate", CURVE, sem=np.zeros(11), correlation_ms=100)
    target = Weighted(own, error=4, correlation_ms=50).on(STIMULUS)
    np.testing.assert_array_equal(target.scale, 0.25)
    np.testing.assert_array_equal(target.thinning, 5)
    np.testing.assert_array_equal(Weighted(own, error=4).on(STIMULUS).thinning, 10)
    assert Weighted(Target("rate", CURVE, error=2), weight=4).on(STIMULUS).scale[0] == 1


def test_a_curve_may_be_drawn_without_counting():
    assert not Weighted(Target("smp", CURVE), weight=0).on(STIMULUS).scale.any()
    assert not Target("smp", CURVE, FRAMES, weight=0, interpolate=True).on(STIMULUS).scale.any()


@pytest.mark.parametrize(
    ("window", "message"),
    [
        ({"from_ms": 60}, "from_ms 60 to until_ms inf holds no frame that counts; the stimulus covers -50 to 50 ms"),
        ({"until_ms": -60}, "from_ms -inf to until_ms -60 holds no frame"),
        ({"from_ms": 1, "until_ms": 9}, "holds no frame"),
        ({"from_ms": 40}, "holds no frame that counts"),
    ],
)
def test_a_window_without_frames_is_refused(window, message):
    covered = Target("smp", CURVE, FRAMES - 20, interpolate=True)
    with pytest.raises(ValueError, match=message):
        Weighted(covered, **window).on(STIMULUS)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"error": 0}, "error is 0; give a positive number"),
        ({"error": np.nan}, "error is nan"),
        ({"weight": -2}, "weight is -2; give 0 or more"),
        ({"from_ms": 5, "until_ms": 2}, "from_ms is 5 and until_ms 2; the window must have an extent"),
        ({"from_ms": np.nan}, "from_ms is nan"),
        ({"correlation_ms": -3}, "correlation_ms is -3 ms"),
    ],
)
def test_a_weighting_that_cannot_be_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        Weighted(Target("smp", CURVE), **change)
