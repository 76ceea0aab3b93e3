"""The eye: fields of view, presets, and where its pixels look."""

import dataclasses

import jax
import numpy as np
import pytest

from lgmd2jax import Eye

EQUIDISTANT = Eye(rows=40, cols=60, degrees_per_pixel=1.5, fps=100)
PINHOLE = dataclasses.replace(EQUIDISTANT, projection="pinhole")


def test_colias_sees_70_degrees_through_a_pinhole():
    eye = Eye.preset("colias")
    assert (eye.rows, eye.cols, eye.fps, eye.projection) == (72, 99, 30, "pinhole")
    height, width = eye.field_of_view
    assert width == pytest.approx(70)
    assert np.tan(np.radians(height / 2)) / np.tan(np.radians(35)) == pytest.approx(72 / 99)
    focal = 99 / 2 / np.tan(np.radians(35))
    assert eye.focal_px == pytest.approx(focal)
    assert eye.degrees_per_pixel == pytest.approx(2 * np.degrees(np.arctan(0.5 / focal)))


def test_equidistant_eye_divides_its_field_evenly():
    eye = Eye.from_field_of_view(50, 100, 120, fps=60)
    assert eye.degrees_per_pixel == pytest.approx(1.2)
    assert eye.field_of_view == pytest.approx((60, 120))


def test_paper_is_a_screen_in_pixels_that_refuses_degrees():
    eye = Eye.preset("paper")
    assert (eye.rows, eye.cols, eye.degrees_per_pixel) == (240, 320, None)
    for ask in (lambda: eye.project(1.0), eye.angles, lambda: eye.field_of_view, lambda: eye.pixels_per_degree):
        with pytest.raises(ValueError, match="has no degrees_per_pixel"):
            ask()


def test_locust_samples_at_a_degree_or_two_and_100_to_200_hz():
    eye = Eye.preset("locust")
    assert 1 <= eye.pixels_per_degree**-1 <= 2
    assert 100 <= eye.fps <= 200


@pytest.mark.parametrize("eye", [EQUIDISTANT, PINHOLE], ids=["equidistant", "pinhole"])
def test_angles_are_those_of_the_rays_through_the_pixel_centres(eye):
    azimuth, elevation = eye.angles()
    assert azimuth.shape == elevation.shape == (40, 60)
    assert np.all(np.diff(azimuth, axis=1) > 0)
    assert np.all(np.diff(elevation, axis=0) < 0)
    assert azimuth.sum() == pytest.approx(0, abs=1e-9)
    if eye.projection == "equidistant":
        assert np.allclose(np.diff(azimuth), 1.5)
        assert azimuth[0, 0] == pytest.approx(-29.5 * 1.5)
        return
    right, up = eye.pixel_centres()
    rays = np.stack([right, up, np.full_like(right, eye.focal_px)])
    rays /= np.linalg.norm(rays, axis=0)
    assert np.allclose(elevation, np.degrees(np.arcsin(rays[1])))
    assert np.allclose(np.sin(np.radians(azimuth)) * np.cos(np.radians(elevation)), rays[0])
    assert azimuth[20, 30] - azimuth[20, 29] == pytest.approx(1.5, rel=1e-3)


@pytest.mark.parametrize("eye", [EQUIDISTANT, PINHOLE], ids=["equidistant", "pinhole"])
def test_projection_brings_the_border_of_the_field_to_the_border_of_the_image(eye):
    height, width = eye.field_of_view
    assert eye.project(width / 2) == pytest.approx(30)
    assert eye.project(height / 2) == pytest.approx(20)
    assert jax.grad(eye.project)(0.0) == pytest.approx(eye.pixels_per_degree, rel=1e-3)


def test_eyes_are_equal_by_value_and_can_key_a_cache():
    assert Eye.preset("locust") == Eye.preset("locust")
    assert len({EQUIDISTANT, PINHOLE, dataclasses.replace(PINHOLE, projection="equidistant")}) == 2


@pytest.mark.usefixtures("untyped")
def test_sizes_may_be_numbers_of_numpy():
    eye = Eye(np.int64(40), np.uint16(60), np.float32(1.5), np.float64(100))  # pyright: ignore[reportArgumentType]
    assert eye == EQUIDISTANT
    assert type(eye.rows) is int


BAD = {
    "rows": (lambda: Eye(2, 60, 1.0, 100.0), "rows is 2"),
    "fps": (lambda: Eye(40, 60, 1.0, 0.0), "fps is 0.0"),
    "angle": (lambda: Eye(40, 60, float("nan"), 100.0), "degrees_per_pixel is nan"),
    "projection": (lambda: Eye(**{**dataclasses.asdict(PINHOLE), "projection": "pinhol"}), "choose 'pinhole'"),
    "preset": (lambda: Eye.preset("locus"), "choose 'locust'"),
    "wide pinhole": (lambda: Eye.from_field_of_view(40, 60, 180.0, 100.0, "pinhole"), "less than 180"),
    "no field": (lambda: Eye.from_field_of_view(40, 60, -3.0, 100.0), "positive field of view"),
}


@pytest.mark.parametrize(("make", "message"), BAD.values(), ids=BAD)
@pytest.mark.usefixtures("untyped")
def test_bad_eyes_are_refused_in_one_line(make, message):
    with pytest.raises(ValueError, match=message) as error:
        make()
    assert "\n" not in str(error.value)
