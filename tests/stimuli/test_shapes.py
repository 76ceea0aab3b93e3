"""Shapes as areas of pixels, against scikit-image's discs and rectangles drawn 40 times finer."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from skimage.draw import disk, rectangle

from lgmd2jax.stimuli import _shapes as shapes
from lgmd2jax.stimuli._shapes import Disc, _angle

ROWS, COLS, FINE = 20, 24, 40
DISCS = {
    "in the middle": (0.0, 0.0, 5.0),
    "anywhere": (0.31, -0.77, 3.27),
    "within a pixel": (0.5, 0.6, 0.3),
    "over a corner": (11.2, 9.1, 6.4),
    "off screen": (30.0, 0.0, 3.0),
    "over all": (1.0, 2.0, 40.0),
}


def supersampled(draw) -> np.ndarray:
    canvas = np.zeros((ROWS * FINE, COLS * FINE))
    canvas[draw(canvas.shape)] = 1
    return canvas.reshape(ROWS, FINE, COLS, FINE).mean((1, 3))


def finely(right, up):
    """Fine row and column of a place in pixels from the centre."""
    return FINE * (ROWS / 2 - up) - 0.5, FINE * (right + COLS / 2) - 0.5


@jax.jit
def disc(place):
    return Disc(ROWS, COLS, place[0], place[1], place[2]).coverage()


forward = jax.jit(jax.jacfwd(disc))


@pytest.mark.parametrize("place", DISCS.values(), ids=DISCS)
def test_disc_is_what_scikit_image_draws_finely(place):
    x, y, radius = place
    expected = supersampled(lambda shape: disk(finely(x, y), FINE * radius, shape=shape))
    assert np.max(np.abs(disc(jnp.array(place)) - expected)) < 3e-3


def test_rectangle_is_what_scikit_image_draws_finely():
    left, right, bottom, top = -6.15, 3.6, -14.0, 2.225
    (upper, first), (lower, last) = finely(left, top), finely(right, bottom)
    corners = (np.ceil([upper, first]).astype(int).clip(0), np.floor([lower, last]).astype(int))
    expected = supersampled(lambda shape: rectangle(corners[0], end=corners[1], shape=shape))
    coverage = shapes.Rectangle(ROWS, COLS, *map(jnp.asarray, (left, right, bottom, top))).coverage()
    assert np.max(np.abs(coverage - expected)) < 1e-12


def test_disc_has_its_exact_area_wherever_it_is():
    places = np.random.default_rng(0).uniform([-1, -1, 0.1], [1, 1, 8], (200, 3))
    areas = jax.vmap(disc)(jnp.asarray(places)).sum((1, 2))
    assert np.max(np.abs(areas / (np.pi * places[:, 2] ** 2) - 1)) < 1e-9


def test_single_precision_is_good_to_a_thousandth_of_a_pixel():
    large = jax.jit(lambda x, y, radius: Disc(100, 120, x, y, radius).coverage())
    double, single = (large(*(dtype(value) for value in (0.25, 0.125, 45.5))) for dtype in (jnp.float64, jnp.float32))
    assert single.dtype == jnp.float32
    assert np.max(np.abs(single - double)) < 1e-3
    assert np.all((single >= 0) & (single <= 1))


def test_single_precision_is_finer_still_inside_of_the_disc():
    x, y, radius = (jnp.float32(value) for value in (0.31, -0.77, 41.3))
    area = np.asarray(jax.jit(lambda *place: Disc(100, 120, *place).coverage())(x, y, radius))
    corners = np.hypot(shapes.column_edges(120)[None, :] - 0.31, shapes.row_edges(100)[:, None] + 0.77)
    corners = np.stack([corners[i : 100 + i, j : 120 + j] for i in (0, 1) for j in (0, 1)])
    assert np.max(np.abs(area[corners.max(0) < 41.3 - 1e-4] - 1)) < 2e-5


def test_angles_are_those_of_the_arc_sine_to_the_last_digits():
    radius = 7.3
    x = radius * np.linspace(0, 0.999, 1000)  # nearer to the rim the arc sine is the one that rounds badly
    assert np.max(np.abs(_angle(jnp.asarray(x), jnp.asarray(radius)) - np.arcsin(x / radius))) < 1e-14
    assert abs(float(_angle(jnp.asarray([radius]), jnp.asarray(radius))[0]) - np.pi / 2) < 1e-15


@pytest.mark.parametrize("place", [(0.31, -0.77, 3.27), (0.5, 0.6, 0.3), (11.23, 9.11, 6.43), (0.1, 0.2, 13.3)])
def test_slopes_of_the_area_are_those_of_finite_differences(place):
    place, step = jnp.array(place), 1e-6
    slopes = forward(place)
    for i, unit in enumerate(jnp.eye(3)):
        difference = (disc(place + step * unit) - disc(place - step * unit)) / (2 * step)
        assert np.max(np.abs(slopes[..., i] - difference)) < 1e-7
    assert np.allclose(slopes, jax.jit(jax.jacrev(disc))(place), atol=1e-12)


@pytest.mark.parametrize(
    "place", [(0.0, 0.0, 0.0), (0.5, 0.5, 0.0), (4.0, 3.0, 5.0), (8.0, 2.0, 4.0), (99.0, 0.0, 1.0)]
)
def test_slopes_are_finite_at_size_zero_at_touching_edges_and_off_screen(place):
    assert np.all(np.isfinite(forward(jnp.array(place))))


def test_stripes_are_the_mean_of_fine_ones():
    edges, low, high, count = np.arange(13.0), 1.3, 10.65, 4
    fine = (np.arange(12 * 2000) + 0.5) / 2000
    sign = np.where(np.floor((fine - low) / (high - low) * count) % 2 == 0, 1.0, -1.0) * ((fine > low) & (fine < high))
    stripes = shapes.stripes(jnp.asarray(edges), jnp.asarray(low), jnp.asarray(high), count)
    assert np.max(np.abs(stripes - sign.reshape(12, -1).mean(1))) < 1e-3


def test_stripes_of_no_width_are_nothing_and_have_finite_slopes():
    def stripes(low, high):
        return shapes.stripes(jnp.arange(5.0), low, high, 4)

    point = jnp.asarray(2.0)
    assert np.all(stripes(point, point) == 0)
    slopes = jax.jit(jax.jacfwd(stripes, argnums=(0, 1)))(point, point)
    assert all(np.all(np.isfinite(slope)) for slope in slopes)
