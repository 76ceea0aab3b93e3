"""What the robot's camera sees: each ray gives a strip of a column, exact along its height.

Walls and obstacles stand upright and are equally high, so that the nearest surface hides all behind it. The pixel of a
strip is the mean of the patterns over its height and width, a difference of their integral: nothing flickers, however
small the patterns are in the image.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from lgmd2jax._eye import Eye
from lgmd2jax._types import Map, Scalar
from lgmd2jax.arena._layout import (
    BANDS,
    HEIGHT_CM,
    MOST,
    OBSTACLE_PATCHES,
    PATCH_CM,
    SIDE_CM,
    WALL_PATCHES,
    Layout,
)

EYE_HEIGHT_CM = 4.0  # the camera stands above the robot's centre
FLOOR, ABOVE = 190.0, 230.0  # grey levels of the floor, and of what is higher than the walls
_STRIPS = 3  # of a column
_FAR_CM = 1e4  # where obstacles stand that a layout does not have
_GREY = 135.0  # about the mean of the patterns; integrals of the differences to it stay small, and so exact

Strips = Float[Array, "strip col"]


class Scene(eqx.Module):
    """A layout as arrays of the same shapes for all layouts, in float32, so that robots may be stacked.

    - `centres`, `radii`: of `MOST` obstacles, in cm.
    - `patches`: grey levels less `_GREY`. `integral`: their sum over the patches before each.
    - `noise`, `flicker`, `flicker_hz`, `flicker_phase`: as of a `Layout`.
    """

    centres: Float[Array, "obstacle 2"]
    radii: Float[Array, " obstacle"]
    patches: Float[Array, "band patch"]
    integral: Float[Array, "band patch"]
    noise: Scalar
    flicker: Scalar
    flicker_hz: Scalar
    flicker_phase: Scalar

    @classmethod
    def of(cls, layout: Layout) -> "Scene":
        """The scene of a layout."""
        missing = MOST - len(layout.radii)
        centres = np.pad(layout.centres, ((0, missing), (0, 0)), constant_values=_FAR_CM)
        radii = np.pad(layout.radii, (0, missing), constant_values=1.0)
        patches = layout.patches - _GREY
        integral = np.cumsum(patches, axis=1) - patches
        camera = layout.noise, layout.flicker, layout.flicker_hz, layout.flicker_phase
        values = (centres, radii, patches, integral, *camera)
        return cls(*(jnp.asarray(value, jnp.float32) for value in values))


def render(eye: Eye, scene: Scene, place: Float[Array, "2"], heading: Scalar) -> Map:
    """The image in grey levels, without noise, from a place in cm and a heading in radians.

    **Arguments:** `eye`: a pinhole. `place`: free of walls and obstacles.
    """
    right_px = (np.arange(eye.cols * _STRIPS, dtype=np.float32).reshape(eye.cols, _STRIPS).T + 0.5) / _STRIPS
    slope = (right_px - eye.cols / 2) / eye.focal_px
    depth, along, width, first, patches = _hits(scene, place, heading, jnp.asarray(slope, jnp.float32))
    width = width / (eye.focal_px * _STRIPS)
    bands = _mean_patches(scene, along, width, first, patches)

    def integral(up: Scalar) -> Strips:
        """Of the grey levels from the floor to the upper edge of a row of pixels."""
        height = EYE_HEIGHT_CM + depth * up
        total = (FLOOR - _GREY) * jnp.minimum(height, 0) + (ABOVE - _GREY) * jnp.maximum(height - HEIGHT_CM, 0)
        for band in range(BANDS):
            total = total + bands[band] * jnp.clip(height - band * PATCH_CM, 0, PATCH_CM)
        return total / depth

    edges = (eye.rows / 2 - np.arange(eye.rows + 1)) / eye.focal_px
    # A loop, since XLA would compute all of a strip anew for each of its pixels.
    integrals = jax.lax.map(integral, jnp.asarray(edges, jnp.float32)).sum(axis=1)
    return _GREY + (integrals[:-1] - integrals[1:]) * (eye.focal_px / _STRIPS)


def film(
    scene: Scene, image: Map, noise: Map, time: Scalar) -> Map:
    """An image as the camera delivers it, in whole grey levels 0..255.

    **Arguments:** `noise` of standard deviation 1; `time` in s.
    """
    light = 1 + scene.flicker * jnp.sin(2 * np.pi * scene.flicker_hz * time + scene.flicker_phase)
    return jnp.round(jnp.clip(image * light + scene.noise * noise, 0, 255))


def _hits(
    scene: Scene, place: Float[Array, "2"], heading: Scalar, slope: Strips
) -> tuple[Strips, Strips, Strips, Int[Array, "strip col"], Int[Array, "strip col"]]:
    """Where the strips hit.

    Depth along the camera's axis and place along the surface, in cm; how wide a strip of slope 1 is on it, in cm; the
    first patch of the surface, and how many it has.
    """
    ahead = jnp.stack([jnp.cos(heading), jnp.sin(heading)])
    right = jnp.stack([ahead[1], -ahead[0]])
    ray = ahead[:, None, None] + right[:, None, None] * slope  # a depth of 1 along each
    # The walls: where the ray leaves the square.
    towards_far = ray > 0
    each_depth = (jnp.where(towards_far, SIDE_CM, 0) - place[:, None, None]) / jnp.where(ray == 0, 1e-9, ray)
    across = each_depth[0] < each_depth[1]  # whether it is a wall of constant x
    depth = jnp.minimum(each_depth[0], each_depth[1])
    hit = place[:, None, None] + depth * ray
    wall = jnp.where(across, jnp.where(towards_far[0], 1, 3), jnp.where(towards_far[1], 2, 0))
    along = SIDE_CM * wall + jnp.clip(jnp.where(across, hit[1], hit[0]), 0, SIDE_CM)
    facing = jnp.abs(jnp.where(across, ray[0], ray[1]))
    # The obstacles: the nearest one before the wall.
    centre = scene.centres - place
    squared = (ray**2).sum(0)
    middle = jnp.einsum("dsc,od->osc", ray, centre)
    excess = ((centre**2).sum(1) - scene.radii**2)[:, None, None]
    discriminant = middle**2 - squared * excess
    met = (discriminant > 0) & (middle > 0)
    root = jnp.sqrt(jnp.where(met, discriminant, 0))
    obstacle_depth = jnp.where(met, (middle - root) / squared, jnp.inf)
    nearest = jnp.argmin(obstacle_depth, axis=0)
    at = obstacle_depth.min(axis=0)
    before_wall = at < depth
    radius = scene.radii[nearest]
    normal = (jnp.where(before_wall, at, 0) * ray - jnp.moveaxis(centre[nearest], -1, 0)) / radius
    turn = jnp.arctan2(normal[1], normal[0]) / (2 * np.pi) + 0.5
    obstacle_facing = jnp.maximum(jnp.abs((normal * ray).sum(0)), 1e-3)
    # Patches of an obstacle are as many for all radii, and a little narrower on the thin ones.
    patch = 2 * np.pi * radius / OBSTACLE_PATCHES
    return (
        jnp.where(before_wall, at, depth),
        jnp.where(before_wall, turn * OBSTACLE_PATCHES, along / PATCH_CM),
        jnp.where(before_wall, at / obstacle_facing / patch, depth / facing / PATCH_CM),
        jnp.where(before_wall, WALL_PATCHES + nearest * OBSTACLE_PATCHES, 0),
        jnp.where(before_wall, OBSTACLE_PATCHES, WALL_PATCHES),
    )


def _mean_patches(
    scene: Scene, along: Strips, width: Strips, first: Int[Array, "strip col"], patches: Int[Array, "strip col"]
) -> Float[Array, "band strip col"]:
    """Mean of the patterns over the width of each strip."""
    low = jnp.clip(along - width / 2, 0, patches - 1e-3)
    high = jnp.clip(along + width / 2, low + 1e-4, patches)

    def integral(place):
        patch = jnp.clip(jnp.floor(place).astype(jnp.int32), 0, patches - 1)
        rows = first + patch
        return scene.integral[:, rows] + (place - patch) * scene.patches[:, rows]

    return (integral(high) - integral(low)) / (high - low)
