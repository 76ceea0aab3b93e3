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

from lgmd2jax._arguments.checked import checked
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

EYE = Eye.preset("colias")
"""The robot's camera: 72 x 99 pixels, 70 degrees wide, 30 frames a second, as the paper's."""
EYE_HEIGHT_CM = 4.0  # the camera stands above the robot's centre
FLOOR, ABOVE = 190.0, 230.0  # grey levels of the floor, and of what is higher than the walls
_STRIPS = 3  # of a column
_FAR_CM = 1e4  # where obstacles stand that a layout does not have
_GREY = 135.0  # about the mean of the patterns; integrals of the differences to it stay small, and so exact

_PARALLEL = 1e-3  # how little a ray may face a surface

Strips = Float[Array, " strip"]


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
    @checked
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


class _Hit(eqx.Module):
    """Where strips hit a surface.

    - `depth`: along the camera's axis, in cm.
    - `along`: place on the surface, in patches. `width`: of a strip of slope 1, in patches.
    - `first`, `count`: the patches of the surface.
    """

    depth: Strips
    along: Strips
    width: Strips
    first: Int[Array, " strip"]
    count: Int[Array, " strip"]


@checked
def render(eye: Eye, scene: Scene, place: Float[Array, "2"], heading: Scalar) -> Map:
    """The image in grey levels, without noise, from a place in cm and a heading in radians.

    **Arguments:** `eye`: a pinhole. `place`: free of walls and obstacles.
    """
    right_px = (np.arange(eye.cols * _STRIPS) + 0.5) / _STRIPS - eye.cols / 2
    hit = _cast(scene, place, heading, jnp.asarray(right_px / eye.focal_px, jnp.float32))
    bands = _mean_patches(scene, hit, 1 / (eye.focal_px * _STRIPS))

    def integral(up: Scalar) -> Strips:
        """Of the grey levels from the floor to the upper edge of a row of pixels, by depth."""
        height = EYE_HEIGHT_CM + hit.depth * up
        total = (FLOOR - _GREY) * jnp.minimum(height, 0) + (ABOVE - _GREY) * jnp.maximum(height - HEIGHT_CM, 0)
        for band in range(BANDS):
            total = total + bands[band] * jnp.clip(height - band * PATCH_CM, 0, PATCH_CM)
        return total / hit.depth

    edges = (eye.rows / 2 - np.arange(eye.rows + 1)) / eye.focal_px
    # A loop, since XLA would compute all of a strip anew for each of its pixels.
    integrals = jax.lax.map(integral, jnp.asarray(edges, jnp.float32))
    strips = (integrals[:-1] - integrals[1:]) * eye.focal_px
    return _GREY + strips.reshape(eye.rows, eye.cols, _STRIPS).mean(axis=2)


def film(scene: Scene, image: Map, noise: Map, time: Scalar) -> Map:
    """An image as the camera delivers it, in whole grey levels 0..255.

    **Arguments:** `noise` of standard deviation 1; `time` in s.
    """
    light = 1 + scene.flicker * jnp.sin(2 * np.pi * scene.flicker_hz * time + scene.flicker_phase)
    return jnp.round(jnp.clip(image * light + scene.noise * noise, 0, 255))


def _cast(scene: Scene, place: Float[Array, "2"], heading: Scalar, slope: Strips) -> _Hit:
    """Where rays of these slopes to the right of the camera's axis hit a surface first."""
    ahead_x, ahead_y = jnp.cos(heading), jnp.sin(heading)
    ray_x, ray_y = ahead_x + ahead_y * slope, ahead_y - ahead_x * slope  # to a depth of 1
    wall = _walls(place, ray_x, ray_y)
    obstacle = _obstacles(scene, place, ray_x, ray_y)
    return jax.tree.map(lambda near, far: jnp.where(obstacle.depth < wall.depth, near, far), obstacle, wall)


def _walls(place: Float[Array, "2"], ray_x: Strips, ray_y: Strips) -> _Hit:
    """Where rays leave the square."""
    depth_x = (jnp.where(ray_x > 0, SIDE_CM, 0) - place[0]) / jnp.where(ray_x == 0, -_PARALLEL, ray_x)
    depth_y = (jnp.where(ray_y > 0, SIDE_CM, 0) - place[1]) / jnp.where(ray_y == 0, -_PARALLEL, ray_y)
    of_constant_x, depth = depth_x < depth_y, jnp.minimum(depth_x, depth_y)
    number = jnp.where(of_constant_x, jnp.where(ray_x > 0, 1, 3), jnp.where(ray_y > 0, 2, 0))
    along = jnp.clip(jnp.where(of_constant_x, place[1] + depth * ray_y, place[0] + depth * ray_x), 0, SIDE_CM)
    facing = jnp.abs(jnp.where(of_constant_x, ray_x, ray_y))
    count = jnp.full(number.shape, WALL_PATCHES // 4)
    return _Hit(depth, along / PATCH_CM, depth / facing / PATCH_CM, number * count, count)


def _obstacles(scene: Scene, place: Float[Array, "2"], ray_x: Strips, ray_y: Strips) -> _Hit:
    """Where rays hit the nearest obstacle; at infinite depth where they hit none."""
    x, y = scene.centres[:, :1] - place[0], scene.centres[:, 1:] - place[1]
    squared = ray_x**2 + ray_y**2
    middle = x * ray_x[None] + y * ray_y[None]
    discriminant = middle**2 - squared[None] * (x**2 + y**2 - scene.radii[:, None] ** 2)
    meets = (discriminant > 0) & (middle > 0)
    depths = jnp.where(meets, (middle - jnp.sqrt(jnp.where(meets, discriminant, 0))) / squared[None], jnp.inf)
    nearest, depth = jnp.argmin(depths, axis=0), depths.min(axis=0)
    radius = scene.radii[nearest]
    known = jnp.where(jnp.isfinite(depth), depth, 0)
    normal_x, normal_y = (known * ray_x - x[nearest, 0]) / radius, (known * ray_y - y[nearest, 0]) / radius
    facing = jnp.maximum(jnp.abs(normal_x * ray_x + normal_y * ray_y), _PARALLEL)
    # Obstacles have equally many patches, which are narrower on the thin ones.
    patch = 2 * np.pi * radius / OBSTACLE_PATCHES
    along = (jnp.arctan2(normal_y, normal_x) / (2 * np.pi) + 0.5) * OBSTACLE_PATCHES
    first = WALL_PATCHES + nearest * OBSTACLE_PATCHES
    return _Hit(depth, along, depth / facing / patch, first, jnp.full(first.shape, OBSTACLE_PATCHES))


def _mean_patches(scene: Scene, hit: _Hit, slope: float) -> Float[Array, "band strip"]:
    """Mean of the patterns over the width of strips of this slope."""
    low = jnp.clip(hit.along - hit.width * slope / 2, 0, hit.count - 1e-3)
    high = jnp.clip(hit.along + hit.width * slope / 2, low + 1e-4, hit.count)

    def integral(place: Strips) -> Float[Array, "band strip"]:
        patch = jnp.clip(jnp.floor(place).astype(int), 0, hit.count - 1)
        of_whole, own = scene.integral[:, hit.first + patch], scene.patches[:, hit.first + patch]
        return of_whole + (place - patch)[None] * own

    return (integral(high) - integral(low)) / (high - low)[None]
