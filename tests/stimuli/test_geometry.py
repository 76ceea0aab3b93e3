"""Where objects are and how large, read off the frames: against the formulas of the geometry."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lgmd2jax import Eye, stimuli

EYE = Eye(rows=40, cols=50, degrees_per_pixel=2.0, fps=100.0)
PINHOLE = dataclasses.replace(EYE, degrees_per_pixel=1.0, projection="pinhole")
SCREEN = Eye(rows=40, cols=50, degrees_per_pixel=None, fps=50.0)
CENTROID = 0.02  # pixels: what is lost by taking a pixel's share of an edge to be in its middle
WINDOW: dict[str, Any] = {"start_ms": -400, "end_ms": 100}
CROSSING: dict[str, Any] = {"start_ms": -100, "end_ms": 1000}


def coverage(stimulus, background=200.0, level=20.0):
    """Share of each pixel that the object takes."""
    return (background - np.asarray(stimulus.frames)) / (background - level)


def radius_px(stimulus):
    """Of a disc, from its area."""
    return np.sqrt(coverage(stimulus).sum((1, 2)) / np.pi)


def centroid_px(stimulus):
    """To the right of and above the centre."""
    mass = coverage(stimulus)
    right, up = EYE.pixel_centres()
    total = np.maximum(mass.sum((1, 2)), 1e-12)
    return (mass * right).sum((1, 2)) / total, (mass * up).sum((1, 2)) / total


@pytest.mark.parametrize("l_over_v", [10.0, 40.0])
@pytest.mark.parametrize("eye", [EYE, PINHOLE], ids=["equidistant", "pinhole"])
def test_disc_looms_by_its_law(eye, l_over_v):
    stop_angle = {"equidistant": 70.0, "pinhole": 30.0}[eye.projection]
    stimulus = stimuli.looming(eye, l_over_v=l_over_v, stop_angle=stop_angle, **WINDOW)
    before = np.maximum(-np.asarray(stimulus.time), 1e-9)
    full_angle = np.clip(2 * np.degrees(np.arctan(l_over_v / before)), 2, stop_angle)
    if eye.projection == "equidistant":
        expected = full_angle / 2 / eye.degrees_per_pixel
    else:
        expected = np.tan(np.radians(full_angle / 2)) / (2 * np.tan(np.radians(eye.degrees_per_pixel / 2)))
    assert np.max(np.abs(radius_px(stimulus) - expected)) < 1e-6
    assert np.allclose(stimulus.courses["full_angle_deg"], full_angle)
    area = coverage(stimulus).sum((1, 2))
    assert np.max(np.abs(area / (np.pi * expected**2) - 1)) < 1e-9


def test_square_has_the_same_angle_from_side_to_side():
    square = stimuli.looming(EYE, shape="square", **WINDOW)
    side = np.sqrt(coverage(square).sum((1, 2)))
    assert np.max(np.abs(side - np.asarray(square.courses["full_angle_deg"]) / EYE.degrees_per_pixel)) < 1e-9


def test_area_is_smooth_in_time():
    """Steps of the edge from pixel to pixel would show in the second difference of the radius."""
    eye = dataclasses.replace(EYE, fps=1000.0)
    radius = radius_px(stimuli.looming(eye, l_over_v=40, start_ms=-300, end_ms=-60))
    bend = np.diff(radius, 2)
    assert np.all(bend > 0)
    assert np.all(np.diff(bend) > 0)


def test_receding_is_looming_backwards():
    looming = stimuli.looming(EYE, l_over_v=30, start_ms=-540, end_ms=-40)
    receding = stimuli.receding(
        EYE, l_over_v=30, start_angle=2 * np.degrees(np.arctan(30 / 40)), start_ms=0, end_ms=500
    )
    assert np.max(np.abs(looming.frames[::-1] - receding.frames)) < 1e-9


def test_recession_follows_the_hold_as_a_mirror_image():
    stimulus = stimuli.approach_recession(EYE, l_over_v=6, stop_angle=60, hold_ms=200, start_ms=-150, end_ms=350)
    angle, time = np.asarray(stimulus.courses["full_angle_deg"]), np.asarray(stimulus.time)
    arrival = -6 / np.tan(np.radians(30))
    stands = (time > arrival) & (time < arrival + 200)
    assert np.allclose(angle[stands], 60)
    assert np.all(angle[~stands] < 60)
    folded = 2 * np.degrees(np.arctan(6 / np.maximum(np.abs(time - arrival - 100) - 100 - arrival, 1e-9)))
    assert np.allclose(angle[~stands], np.maximum(folded[~stands], 2))


def test_full_angle_can_grow_linearly():
    stimulus = stimuli.looming(EYE, growth=100, stop_angle=60, **WINDOW)
    expected = np.clip(60 + 0.1 * np.asarray(stimulus.time), 2, 60)
    assert np.max(np.abs(radius_px(stimulus) * 2 * EYE.degrees_per_pixel - expected)) < 1e-6


def test_edge_on_a_screen_moves_and_accelerates_as_asked():
    stimulus = stimuli.looming(
        SCREEN, growth_px=20, acceleration_px=60, start_radius_px=2, stop_radius_px=15, start_ms=-700, end_ms=200
    )
    radius = radius_px(stimulus)
    assert radius[0] == pytest.approx(2)
    assert np.allclose(radius[np.asarray(stimulus.time) >= 0], 15)
    onset = -(np.sqrt(20**2 + 2 * 60 * 13) - 20) / 60
    since = np.clip(np.asarray(stimulus.time) / 1000 - onset, 0, -onset)
    assert np.allclose(radius, 2 + 20 * since + 30 * since**2)


def test_ball_rolls_down_a_slope_as_integration_has_it():
    law = stimuli.Rolling(slope_height_cm=20, slope_length_cm=80, radius_cm=2.5)
    steps = np.linspace(0, 2, 200_001)
    position = 0.5 * (5 / 7 * 981 * 20 / 80) * steps**2
    arrival = steps[np.searchsorted(position, 80)]
    time = jnp.asarray([-2500.0, -800.0, -300.0, -50.0])
    expected = (80 - np.interp(arrival + np.asarray(time) / 1000, steps, position)) / 2.5
    assert np.allclose(law(time), expected, atol=1e-2)
    final = np.sqrt(10 / 7 * 981 * 20)
    assert law(jnp.asarray([-1.0]))[0] == pytest.approx(final * 1e-3 / 2.5, rel=1e-2)
    assert law.reached(law(time)[1]) == pytest.approx(-800)


def test_any_distance_can_be_given_as_a_table():
    table = stimuli.Tabulated(time_ms=[-400.0, 0.0], distance=[10.0, 0.0])
    assert np.allclose(
        stimuli.looming(EYE, distance=table, **WINDOW).frames, stimuli.looming(EYE, l_over_v=40, **WINDOW).frames
    )


@pytest.mark.parametrize("eye", [EYE, PINHOLE], ids=["equidistant", "pinhole"])
def test_near_miss_passes_where_trigonometry_has_it(eye):
    deviation, l_over_v = np.radians(20.0), 20.0
    stimulus = stimuli.looming(
        eye, l_over_v=l_over_v, start_angle=10, deviation=20, deviation_direction=90, start_ms=-400, end_ms=100
    )
    time = np.asarray(stimulus.time)
    start = l_over_v / np.tan(np.radians(5))
    path = np.maximum(start + time, 0)
    depth, offset = start - path * np.cos(deviation), path * np.sin(deviation)
    distance = np.hypot(depth, offset)
    assert np.allclose(stimulus.courses["full_angle_deg"], 2 * np.degrees(np.arctan(l_over_v / distance)))
    _, up = centroid_px(stimulus)
    if eye.projection == "equidistant":
        expected = np.degrees(np.arctan2(offset, depth)) / eye.degrees_per_pixel
    else:
        expected = eye.focal_px * offset / depth
    whole = (depth > 0) & (expected + np.asarray(stimulus.courses["radius_px"]) < eye.rows / 2)
    assert whole.sum() > 5
    assert np.max(np.abs(up - expected)[whole]) < CENTROID


def test_straight_course_is_the_limit_of_near_misses():
    straight = stimuli.looming(EYE, **WINDOW).frames
    assert np.max(np.abs(stimuli.looming(EYE, deviation=1e-6, **WINDOW).frames - straight)) < 0.01


@pytest.mark.parametrize("direction", [0.0, 37.0, 180.0, 270.0])
def test_translation_moves_the_centroid_at_the_asked_speed(direction):
    stimulus = stimuli.translating(
        EYE, speed=50, size=12, start=-20, stop=20, direction=direction, azimuth=4, **CROSSING
    )
    right, up = centroid_px(stimulus)
    heading = np.radians(direction)
    position = np.clip(-20 + 50 * np.asarray(stimulus.time) / 1000, -20, 20) * EYE.pixels_per_degree
    assert np.max(np.abs(right - 2 - position * np.cos(heading))) < CENTROID
    assert np.max(np.abs(up - position * np.sin(heading))) < CENTROID
    moving = (np.asarray(stimulus.time) >= 0) & (np.asarray(stimulus.time) <= 800)
    speed = np.polyfit(stimulus.time[moving] / 1000, right[moving], 1)[0] * EYE.degrees_per_pixel
    assert speed == pytest.approx(50 * np.cos(heading), abs=0.02)


@pytest.mark.parametrize(
    ("profile", "power"), [("constant", 0), ("linear", 1), ("accelerating", 2), ("decelerating", None)]
)
def test_speed_changes_as_its_profile_says(profile, power):
    stimulus = stimuli.translating(EYE, speed=40, start=-20, stop=20, profile=profile, **CROSSING)
    position = np.asarray(stimulus.courses["position_deg"])
    middle = np.asarray(stimulus.time)[10:-1] / 1000 + 0.005
    expected = 40 * (2 * (1 - middle) if power is None else (power + 1) * middle**power)
    assert np.allclose(np.diff(position[10:]) * EYE.fps, expected, atol=0.02)
    assert position[[0, -1]] == pytest.approx([-20, 20])


@pytest.mark.parametrize("eye", [EYE, PINHOLE], ids=["equidistant", "pinhole"])
def test_object_that_passes_at_a_distance_has_the_size_of_perspective(eye):
    stimulus = stimuli.translating(eye, distance_cm=30, size_cm=6, speed_cm_s=40, start=-18, stop=18, **CROSSING)
    position = np.asarray(stimulus.courses["position_cm"])
    assert position[[0, -1]] == pytest.approx(30 * np.tan(np.radians([-18, 18])))
    right, _ = centroid_px(stimulus)
    if eye.projection == "equidistant":
        angle, half = np.arctan(position / 30), np.arctan(3 / np.hypot(position, 30))
        expected, size = np.degrees(angle) / 2, np.degrees(half) / 2
    else:
        expected, size = eye.focal_px * position / 30, eye.focal_px * 3 / 30
    assert np.max(np.abs(right - expected)) < CENTROID
    assert np.max(np.abs(radius_px(stimulus) - size)) < 1e-6


@pytest.mark.parametrize("direction", [0, 90, 180, 270])
def test_bar_grows_and_shrinks_by_one_edge(direction):
    ways = {"width": 10, "speed": 50, "start": -20, "stop": 20, "direction": direction}
    grows, shrinks = stimuli.elongating(EYE, **ways), stimuli.shortening(EYE, **ways)
    done = np.clip(50 * np.asarray(grows.time) / 1000, 0, 40) * EYE.pixels_per_degree
    assert np.allclose(coverage(grows).sum((1, 2)), 5 * done)
    assert np.allclose(coverage(shrinks).sum((1, 2)), 5 * (20 - done))
    heading, half_way = np.radians(direction), np.searchsorted(grows.time, 400)
    right, up = (centre[half_way] for centre in centroid_px(grows))
    assert [right, up] == pytest.approx([-5 * np.cos(heading), -5 * np.sin(heading)])


def test_units_of_the_paper_are_pixels_and_grey_levels():
    degrees = stimuli.translating(EYE, speed=50, size=10, start=-20, stop=20, contrast=-0.9, **CROSSING)
    pixels = stimuli.translating(EYE, speed_px=25, size_px=5, start_px=-10, stop_px=10, level=20, **CROSSING)
    assert np.allclose(degrees.frames, pixels.frames)
    assert "contrast" in degrees.parameters
    assert "contrast" not in pixels.parameters


def test_checks_are_fixed_to_the_object():
    stimulus = stimuli.looming(EYE, shape="square", checks=4, stop_angle=64, start_ms=-60, end_ms=0)
    last = np.asarray(stimulus.frames[-1])[4:36, 9:41]
    first, other = last[:8, :8], last[:8, 8:16]
    assert np.allclose(first, 20)
    assert np.allclose(other, 110)
    assert np.allclose(last, np.tile(np.block([[first, other], [other, first]]), (2, 2)))
    small = np.asarray(stimuli.looming(EYE, shape="square", checks=4, stop_angle=3, start_ms=-60, end_ms=0).frames[-1])
    assert 200 - (200 - small).sum() / 1.5**2 == pytest.approx(65)


def test_time_runs_in_whole_frames_with_zero_among_them():
    eye = dataclasses.replace(EYE, fps=30.0)
    stimulus = stimuli.looming(eye, l_over_v=20)
    index = np.asarray(stimulus.time) * 30 / 1000
    assert np.allclose(index, np.round(index), atol=1e-9)
    assert np.any(np.asarray(stimulus.time) == 0)
    onset, stop = -20 / np.tan(np.radians(1)), -20 / np.tan(np.radians(40))
    assert stimulus.time[0] == pytest.approx(onset - 500, abs=1000 / 30)
    assert stimulus.time[-1] == pytest.approx(stop + 500, abs=1000 / 30)


def test_window_follows_from_numbers_also_where_others_are_traced():
    def peak(contrast):
        return stimuli.looming(EYE, l_over_v=5, contrast=contrast).frames.min()

    assert jax.jit(peak)(-0.5) == pytest.approx(100)
