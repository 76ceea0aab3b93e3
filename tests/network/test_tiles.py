"""A field in tiles computes what the whole field does."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax._network import tiles
from lgmd2jax._types import cast
from tests import clips

FRAMES = jnp.asarray(clips.loom(3, (12, 12, 8)) + 3 * clips.noise(8, (12, 12, 8)) / 245)
PARAMETERS = lgmd.Parameters(theta1=0.4, theta2=1.3, theta3=0.02, T_s=15.0, T_ffi=46.0, k=60.0, u=0.7, sigma1=0.2)
SOFT = lgmd.Soft(0.5)
INTERVAL = jnp.asarray(1000 / 30)


@pytest.fixture
def in_fours(monkeypatch):
    """Tiles of four rows."""
    monkeypatch.setattr(tiles, "_ROWS", 4)
    monkeypatch.setattr(tiles, "_BYTES", 0)
    assert tiles.tile_height(*FRAMES.shape[1:]) == 4


def sums(parameters, thresholds, structure, interval=INTERVAL, frames=FRAMES):
    return lgmd.LGMD2(parameters, thresholds, **structure).sums(frames, interval)[0]


def plain(parameters, thresholds, structure, interval=INTERVAL, frames=FRAMES):
    pixels = lgmd.LGMD2(cast(parameters, frames.dtype), thresholds, **structure).pixels
    return pixels.plain(frames, interval)[0]


def assert_close(found, expected):
    for leaf, other in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(leaf, other, rtol=0, atol=1e-11 * np.abs(other).max())


@pytest.mark.parametrize(
    "structure", [{"n_p": 2}, {"mechanisms": ("size",)}, {"mechanisms": ("lamina", "habituation")}], ids=str
)
def test_sums_and_their_derivatives_are_those_of_the_whole_field(in_fours, structure):
    def with_derivatives(of):
        return jax.jit(lambda *inputs: (of(*inputs, SOFT, structure), jax.jacfwd(of)(*inputs, SOFT, structure)))

    assert_close(with_derivatives(sums)(PARAMETERS), with_derivatives(plain)(PARAMETERS))


@pytest.mark.parametrize("mechanisms", [(), ("size",)])
def test_integers_give_what_floats_do(in_fours, mechanisms):
    levels = jnp.round(FRAMES).astype(jnp.uint8)
    assert (levels.max(axis=0) > levels.min(axis=0)).any()

    def with_derivatives(frames):
        def of(parameters):
            return sums(parameters, SOFT, {"mechanisms": mechanisms}, frames=frames)

        return jax.jit(lambda parameters: (of(parameters), jax.jacfwd(of)(parameters)))(PARAMETERS)

    assert_close(with_derivatives(levels), with_derivatives(levels.astype(float)))


def test_a_batch_at_an_uneven_clock(in_fours):
    films, interval = jnp.stack([FRAMES, FRAMES[:, ::-1]]), jnp.linspace(20.0, 50.0, len(FRAMES))

    def respond(of):
        return jax.vmap(lambda frames: of(PARAMETERS, lgmd.Hard(), {}, interval, frames))(films)

    assert_close(respond(sums), respond(plain))


def test_a_pixel_that_is_not_a_number_shows_in_whichever_tile_it_is(in_fours):
    found = jax.jit(lambda row: sums(PARAMETERS, lgmd.Hard(), {}, frames=FRAMES.at[5, row, 3].set(jnp.nan)))
    for row in range(len(FRAMES[0])):
        np.testing.assert_array_equal(np.flatnonzero(np.isnan(found(row).f)), [5, 6])


@pytest.mark.parametrize(
    ("rows", "cols", "expected"),
    [(240, 320, 48), (480, 640, 24), (1080, 1920, 15), (72, 99, 72), (241, 320, 241)],
    ids=["QVGA", "VGA", "HD", "small enough as it is", "nothing divides it"],
)
def test_the_height_of_a_tile(rows, cols, expected):
    assert tiles.tile_height(rows, 4 * cols) == expected


def test_a_derivative_has_lower_tiles_since_it_keeps_more_maps():
    assert tiles.tile_height(240, 4 * 320, tiles.DERIVED) == 24
    assert tiles.tile_height(72, 4 * 99, tiles.DERIVED) == 72


@pytest.mark.parametrize("levels", [jnp.uint8, jnp.int16, jnp.float32])
def test_frames_of_any_kind_have_tiles_of_one_height(levels):
    """The maps of a tile are floats, however little room the frames take."""
    heights = []

    def of_tile(first, height):
        heights.append(height)
        return jnp.zeros(())

    tiles.over_tiles(of_tile, jnp.zeros((2, 240, 320), levels))
    assert set(heights) == {48}
