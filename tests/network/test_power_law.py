"""The law that the circuit obeys: an analytic oracle for the time at which feed-forward inhibition closes the gate.

For an approaching disc of Weber contrast c on a ground L, the area that its edge sweeps in a frame times c L, over the
field, is F. With a short tau2, Fbar is F, and its threshold is crossed at tau = const (l/|v|)^(2/3) (c L)^(1/3).
"""

import numpy as np
import pytest

import lgmd2jax as lgmd

EYE = lgmd.Eye(rows=60, cols=60, degrees_per_pixel=1.0, fps=200.0)
BACKGROUND, T_FFI = 200.0, 0.2


def crossing(l_over_v: float, contrast: float) -> float:
    """Time before collision, in ms, at which Fbar of the hard model passes T_ffi, between frames by a straight line."""
    stimulus = lgmd.stimuli.looming(
        EYE,
        l_over_v=l_over_v,
        contrast=contrast,
        background=BACKGROUND,
        start_ms=-1500.0,
        end_ms=-5.0 * 8,
        stop_angle=50.0,
    )
    ffi = np.asarray(lgmd.LGMD2(lgmd.Parameters(tau2=1e-6))(stimulus.frames, EYE.fps).ffi)
    after = int(np.argmax(ffi > T_FFI))
    share = (T_FFI - ffi[after - 1]) / (ffi[after] - ffi[after - 1])
    return -float(stimulus.time[after - 1] + share * 1000 / EYE.fps)


def predicted(l_over_v: float, contrast: float) -> float:
    """The same from geometry alone: area pi atan((l/|v|)/tau)^2, frame by frame."""
    time = np.arange(-300, 0) * 1000 / EYE.fps
    degrees = np.degrees(np.arctan(l_over_v / -time))
    swept = np.diff(np.pi * degrees**2)  # pixels of one square degree
    ffi = abs(contrast) * BACKGROUND * swept / (EYE.rows * EYE.cols)
    after = int(np.argmax(ffi > T_FFI))
    share = (T_FFI - ffi[after - 1]) / (ffi[after] - ffi[after - 1])
    return -float(time[1:][after - 1] + share * 1000 / EYE.fps)


SPEEDS, CONTRASTS = (10.0, 20.0, 40.0, 80.0), (-0.2, -0.4, -0.8)


@pytest.mark.parametrize("contrast", CONTRASTS)
@pytest.mark.parametrize("l_over_v", SPEEDS)
def test_the_gate_closes_when_geometry_says(l_over_v, contrast):
    # To a fifth of a frame.
    assert crossing(l_over_v, contrast) == pytest.approx(predicted(l_over_v, contrast), abs=1.0)


def test_it_is_a_power_law_of_two_thirds_and_one_third():
    speeds = [crossing(l_over_v, -0.8) for l_over_v in SPEEDS]
    contrasts = [crossing(40.0, contrast) for contrast in CONTRASTS]
    by_speed = np.polyfit(np.log(SPEEDS), np.log(speeds), 1)[0]
    by_contrast = np.polyfit(np.log(np.abs(CONTRASTS)), np.log(contrasts), 1)[0]
    assert by_speed == pytest.approx(2 / 3, abs=0.03)
    assert by_contrast == pytest.approx(1 / 3, abs=0.03)


def test_a_long_tau2_closes_it_at_an_angle_instead():
    """Fbar then integrates the area swept so far: the same angle at every speed, so times go as l/|v| itself."""
    threshold, times = 2e-4, []
    for l_over_v in (20.0, 40.0, 80.0):
        stimulus = lgmd.stimuli.looming(
            EYE, l_over_v=l_over_v, contrast=-0.8, background=BACKGROUND, start_ms=-2000.0, end_ms=0.0, stop_angle=60.0
        )
        ffi = np.asarray(lgmd.LGMD2(lgmd.Parameters(tau2=1e6))(stimulus.frames, EYE.fps).ffi)
        times.append(-np.interp(threshold, ffi, np.asarray(stimulus.time)))
    np.testing.assert_allclose(np.polyfit(np.log((20.0, 40.0, 80.0)), np.log(times), 1)[0], 1.0, atol=0.03)
