"""The image of the arena beside one by marching along rays in plain NumPy."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.arena import Layout, Scene, random_layout, render
from lgmd2jax.arena._camera import ABOVE, EYE_HEIGHT_CM, FLOOR, film
from lgmd2jax.arena._layout import BANDS, HEIGHT_CM, OBSTACLE_PATCHES, PATCH_CM, SIDE_CM, WALL_PATCHES

EYE = lgmd.Eye.from_field_of_view(6, 7, 70.0, 30.0, "pinhole")
FINE, STEP_CM = 8, 0.1  # rays along each side of a pixel; how far they go at once


def marched(layout: Layout, place: np.ndarray, heading: float) -> np.ndarray:
    """The image, each pixel the mean of 8 x 8 rays that go on until they are in something."""
    ahead = np.array([np.cos(heading), np.sin(heading), 0])
    right, up = np.array([ahead[1], -ahead[0], 0]), np.array([0, 0, 1.0])
    aside = (np.arange(EYE.cols * FINE) + 0.5) / FINE - EYE.cols / 2
    above = EYE.rows / 2 - (np.arange(EYE.rows * FINE) + 0.5) / FINE
    rays = ahead + (up * above[:, None, None] + right * aside[:, None]) / EYE.focal_px
    rays = rays.reshape(-1, 3)
    point = np.tile([*place, EYE_HEIGHT_CM], (len(rays), 1))
    while True:
        apart = point[:, None, :2] - layout.centres
        within = np.hypot(apart[..., 0], apart[..., 1]) <= layout.radii
        beyond = np.stack([-point[:, 1], point[:, 0] - SIDE_CM, point[:, 1] - SIDE_CM, -point[:, 0]], axis=1)
        there = within.any(axis=1) | (beyond > 0).any(axis=1) | (point[:, 2] <= 0)
        if there.all():
            break
        point = np.where(there[:, None], point, point + STEP_CM * rays)
    wall = beyond.argmax(axis=1)
    along = np.clip(np.where(wall % 2 == 0, point[:, 0], point[:, 1]), 0, SIDE_CM - 1e-6)
    own = within.argmax(axis=1)
    x, y = np.take_along_axis(apart, own[:, None, None], axis=1)[:, 0].T
    turn = np.arctan2(y, x) / (2 * np.pi) + 0.5
    patch = np.where(
        within.any(axis=1),
        WALL_PATCHES + OBSTACLE_PATCHES * own + np.floor(turn * OBSTACLE_PATCHES),
        (SIDE_CM * wall + along) // PATCH_CM,
    ).astype(int)
    z = point[:, 2]
    pattern = layout.patches[np.clip(z // PATCH_CM, 0, BANDS - 1).astype(int), patch]
    grey = np.where(z <= 0, FLOOR, np.where(z > HEIGHT_CM, ABOVE, pattern))
    return grey.reshape(EYE.rows, FINE, EYE.cols, FINE).mean(axis=(1, 3))


@pytest.fixture(scope="module")
def rendered():
    """The renderer, compiled once."""
    return jax.jit(lambda scene, place, heading: render(EYE, scene, place, heading))


@pytest.mark.parametrize(("seed", "turn"), [(1, 0.0), (2, 2.0)])
def test_the_image_is_that_of_rays_that_march(rendered, seed, turn):
    layout = random_layout(seed)
    heading = layout.heading + turn
    image = rendered(Scene.of(layout), *(jnp.asarray(each, jnp.float32) for each in (layout.start, heading)))
    apart = np.abs(np.asarray(image) - marched(layout, layout.start, heading))
    # A strip is a third of a pixel wide and sees one surface, so that the edge of an obstacle may be off by a sixth.
    assert np.median(apart) < 2
    assert np.quantile(apart, 0.9) < 10
    assert apart.max() < 40


def test_a_wall_near_and_straight_ahead_is_one_patch(rendered):
    layout = random_layout(0)
    empty = dataclasses.replace(layout, centres=np.empty((0, 2)), radii=np.empty(0))
    place = jnp.asarray([SIDE_CM - 0.7, 55.0], jnp.float32)  # the camera is 4 cm high, where two patches meet
    image = rendered(Scene.of(empty), place, jnp.zeros((), jnp.float32))
    patch = int((SIDE_CM + 55) / PATCH_CM)
    above, below = layout.patches[2, patch], layout.patches[1, patch]
    np.testing.assert_allclose(image[[2, 3], 3], [above, below], atol=0.1)


def test_a_layout_without_noise_and_flicker_is_filmed_as_it_is_in_whole_grey_levels():
    scene = Scene.of(random_layout(0))
    zero = jnp.zeros((), jnp.float32)
    still = dataclasses.replace(scene, noise=zero, flicker=zero)
    image = jnp.asarray([[0.4, 99.6, 300.0]], jnp.float32)
    noise, time = jnp.ones_like(image), jnp.ones((), jnp.float32)
    assert film(still, image, noise, time).tolist() == [[0.0, 100.0, 255.0]]
    assert np.all(film(scene, image, noise, time) % 1 == 0)
