"""What is measured on curves, against curves whose measures are known by hand."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax._characterise import trials
from lgmd2jax._characterise.curves import (
    Stack,
    curves_of,
    duration,
    highest,
    integral,
    mean,
    peak,
    rise_and_fall,
    second_rise,
)
from lgmd2jax._characterise.exam import Exam
from lgmd2jax._characterise.measures_looming import LOOMS, law_of_peaks, peak_leads
from lgmd2jax._network.stages import Sums
from lgmd2jax._signals import line_through
from tests.characterise.signals import EYE, curves, eta


def stack(values, begin=0.0, end=100.0, start=-50.0):
    """One curve at 100 frames per second."""
    values = jnp.asarray(values, dtype=float)[None]
    count = values.shape[1]
    time = (start + 10.0 * np.arange(count))[None]
    return Stack(values, time, np.array([begin]), np.array([end]), (count,), 10.0)


@pytest.mark.parametrize("at", [40.0, 42.5, 44.9, 36.0])
def test_the_peak_of_a_parabola_is_its_vertex(at):
    time = -50.0 + 10 * np.arange(20)
    top, when = peak(stack(1 - ((time - at) / 100) ** 2))
    assert float(when[0]) == pytest.approx(at, abs=1e-9)
    assert float(top[0]) == pytest.approx(1 - ((10 * round(at / 10) - at) / 100) ** 2)


def test_the_peak_of_a_plateau_is_its_middle():
    values = np.zeros(20)
    values[6:13] = [0.5, 1, 1, 0.9995, 1, 1, 0.5]
    middle = float(peak(stack(values))[1][0])
    assert middle == pytest.approx(-50 + 10 * 9, abs=0.05)  # the crossings lie .02 ms outside of the plateau


def test_a_peak_is_looked_for_during_the_motion_alone():
    values = np.zeros(20)
    values[[2, 8, 18]] = [3.0, 0.5, 2.0]
    top, when = peak(stack(values))
    assert (float(top[0]), float(when[0])) == (0.5, 30.0)


def test_the_frame_that_shows_the_end_still_belongs_to_the_motion():
    values = np.zeros(20)
    values[16] = 0.5
    assert float(peak(stack(values, end=103.0))[0][0]) == 0.5
    assert float(peak(stack(values, end=100.0))[0][0]) == 0.0


def test_what_is_smaller_than_a_peak_has_no_time():
    values = np.zeros(20)
    values[8] = 0.049
    assert np.isnan(float(peak(stack(values))[1][0]))


def test_half_widths_of_a_triangle():
    time = -50.0 + 10 * np.arange(40)
    values = np.where(time < 60, np.maximum(1 - (60 - time) / 80, 0), np.maximum(1 - (time - 60) / 200, 0))
    rise, fall = rise_and_fall(stack(values))
    # The parabola through the top of this triangle lies 2.1 ms late, and both widths are measured from there.
    when = float(peak(stack(values))[1][0])
    assert float(rise[0]) == pytest.approx(when - 20)
    assert float(fall[0]) == pytest.approx(160 - when)


def test_a_curve_that_does_not_come_down_has_no_width():
    assert np.isinf(float(rise_and_fall(stack(np.linspace(0, 1, 20)))[1][0]))
    assert np.isinf(float(rise_and_fall(stack(np.linspace(1, 0.9, 20)))[0][0]))


def test_second_rise():
    values = np.zeros(20)
    values[5:15] = [0.1, 0.4, 0.2, 0.5, 1.0, 0.6, 0.3, 0.65, 0.2, 0.0]
    assert float(second_rise(stack(values))[0]) == pytest.approx(0.35)  # .3 to .65, more than .2 to .4 before the peak
    values[11:13] = 0.3
    assert float(second_rise(stack(values))[0]) == pytest.approx(0.2)  # seen from the peak backwards: .2 to .4


def test_integral_mean_and_duration():
    values = np.full(60, 0.2)
    curve = stack(values)
    assert float(integral(curve)[0]) == pytest.approx(0.2 * 250)  # 0 to 250 ms
    assert float(integral(stack(-values))[0]) == 0
    assert float(mean(curve, curve.between(0, 50))[0]) == pytest.approx(0.2)
    assert float(duration(curve, 0.1)[0]) == 55 * 10
    assert float(duration(curve, 0.2)[0]) == 0


def test_after_the_motion():
    values = np.arange(40.0)
    curve = stack(values)
    assert float(highest(curve, curve.after())[0]) == 39
    assert curve.time[curve.after()][0] == 110
    assert curve.time[curve.after(150.0)][0] == 260


@pytest.mark.parametrize(("alpha", "delta"), [(4.4, 15.0), (5.0, 18.0), (6.5, 30.0)])
def test_the_looming_law_comes_back(alpha, delta):
    """Delta holds a frame on top, which the row takes off.

    At l/|v| 10 ms three frames of 10 ms hold a skew peak of 100 ms to 1.5 ms, at 80 ms to .2 ms.
    """
    neuron = {trials.loom(speed): eta(speed, alpha=alpha, delta=delta + 10) for speed in trials.L_OVER_V}
    answers = curves(neuron, *LOOMS)
    slope, delay = jax.jit(law_of_peaks)(answers)
    assert float(slope) == pytest.approx(alpha, abs=0.02)
    assert float(delay) == pytest.approx(delta, abs=1.2)
    assert np.abs(line_through(peak_leads(answers, *LOOMS), np.array(trials.L_OVER_V))[2]).max() < 1.0


def test_stacks_of_unequal_length_hold_no_more_than_their_curves():
    answers = curves({name: eta(speed) for name, speed in zip(LOOMS, trials.L_OVER_V, strict=True)}, *LOOMS)
    both = answers(LOOMS[0], LOOMS[-1])
    alone = answers(LOOMS[0])
    for measure in (integral, second_rise, lambda each: peak(each)[1], lambda each: highest(each, each.after())):
        assert float(measure(both)[0]) == pytest.approx(float(measure(alone)[0]), rel=1e-12)
    assert both.between(-np.inf, np.inf).sum(axis=1).tolist() == list(both.counts)


def test_the_cell_stage_maps_over_models():
    """One stored MP and F, many cells: the same as one after the other."""
    exam = Exam(EYE, only=(trials.REFERENCE,))
    time = exam.trial(trials.REFERENCE).time
    mp = 3000 * np.exp(-(((time + 150) / 60) ** 2))
    f = 8 * np.exp(-(((time + 100) / 60) ** 2))
    sums = (Sums(jnp.asarray(mp)[None], jnp.asarray(f)[None]),)

    def one(T_ffi, tau3):
        model = lgmd.LGMD2(lgmd.Parameters(T_ffi=T_ffi, tau3=tau3), eye=EYE)
        answer = curves_of(exam, sums, model)(trials.REFERENCE)
        return answer.values[0], peak(answer)[1][0]

    T_ffi, tau3 = jnp.array([2.0, 5.0, 50.0]), jnp.array([100.0, 500.0, 900.0])
    values, times = jax.jit(jax.vmap(one))(T_ffi, tau3)
    of = jax.jit(one)
    for i in range(3):
        alone, when = of(T_ffi[i], tau3[i])
        np.testing.assert_allclose(values[i], alone, atol=1e-12)
        assert float(times[i]) == pytest.approx(float(when))
    assert len({round(float(when), 3) for when in times}) == 3
