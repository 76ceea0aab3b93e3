"""What a camera on a vehicle, on a robot, in a hand or on a post looks at: a street in three dimensions.

Ground, a wall on either side, a picture far away and a sky, with upright objects before them. All of a scene is numbers
in arrays of one size, so that every clip shares one compiled renderer.
"""

import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, Real

from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._eye import Eye
from lgmd2jax._types import Map
from lgmd2jax.stimuli import _texture as texture
from lgmd2jax.stimuli._pieces import in_pieces

OBJECTS = 4  # in every scene; what is not wanted stands behind the camera
_FINER = 2  # rays for each pixel of the eye, in rows and in columns
_TEXELS = 64  # of a side of a surface's pattern
_BLURRED = 7  # times: from no texel to all of them
_GRAINS = 8  # that make a pattern
_PER_PHOTOGRAPH = 4  # patterns
_FAR = 1e4  # m
_UNDERSIDE = -0.6  # of an object's half-height: below it lies its own shadow


class Camera(eqx.Module):
    """Where the camera is in each frame, in m, and how it is turned, in radians: the ground lies at height 0."""

    right: Float[Array | np.ndarray, "*time"]
    height: Float[Array | np.ndarray, "*time"]
    ahead: Float[Array | np.ndarray, "*time"]
    yaw: Float[Array | np.ndarray, "*time"]
    pitch: Float[Array | np.ndarray, "*time"]
    roll: Float[Array | np.ndarray, "*time"]


class Surface(eqx.Module):
    """A pattern on something: its mean grey level, the deviations' standard deviation by mean, and its grain in m.

    Of the picture far away the grain is in radians.
    """

    level: Float[Array | np.ndarray, "*surface"]
    contrast: Float[Array | np.ndarray, "*surface"]
    grain: Float[Array | np.ndarray, "*surface"]
    pattern: Int[Array | np.ndarray, "*surface"]


class Objects(eqx.Module):
    """Upright things that face the camera.

    - `width`, `tall`: half of each side, in m. `shape`: exponent of the outline; 2 for an ellipse.
    - `underside`: factor on what is near the ground. `lamps`: grey levels of two lamps.
    """

    width: Float[Array | np.ndarray, " object"]
    tall: Float[Array | np.ndarray, " object"]
    shape: Float[Array | np.ndarray, " object"]
    underside: Float[Array | np.ndarray, " object"]
    lamps: Float[Array | np.ndarray, " object"]
    surface: Surface


class Motion(eqx.Module):
    """What changes from frame to frame: the camera, and where the middle of each object is, in m."""

    camera: Camera
    right: Float[Array | np.ndarray, "*time object"]
    height: Float[Array | np.ndarray, "*time object"]
    ahead: Float[Array | np.ndarray, "*time object"]


class Scene(eqx.Module):
    """All that the camera looks at.

    - `wall_at`: m to the right and left of the middle. `wall_tall`: m. `far`: the picture behind, up to `skyline`.
    - `lines`: grey levels of the road's markings. `sky`: grey level.
    - `light`: what lights everything; `beam`: what the camera's own lamps add, up to some 15 m ahead.
    - `shade_from`, `shade_to`: m ahead between which everything lies in a shadow that leaves the share `shade`.
    - `lamps`: grey levels of street lamps. `haze`: m at which the sky's level has replaced most of a surface's.
    - `bonnet`: share of the field's height, from below, that a part of the vehicle covers; `bonnet_level`: grey level.
    """

    objects: Objects
    ground: Surface
    wall: Surface
    far: Surface
    wall_at: Float[Array | np.ndarray, " side"]
    wall_tall: Float[Array | np.ndarray, ""]
    skyline: Float[Array | np.ndarray, ""]
    lines: Float[Array | np.ndarray, ""]
    sky: Float[Array | np.ndarray, ""]
    light: Float[Array | np.ndarray, ""]
    beam: Float[Array | np.ndarray, ""]
    shade_from: Float[Array | np.ndarray, ""]
    shade_to: Float[Array | np.ndarray, ""]
    shade: Float[Array | np.ndarray, ""]
    lamps: Float[Array | np.ndarray, ""]
    haze: Float[Array | np.ndarray, ""]
    bonnet: Float[Array | np.ndarray, ""]
    bonnet_level: Float[Array | np.ndarray, ""]

    def shaded(self, ahead: Float[Array | np.ndarray, "*place"]) -> Float[Array, "*place"]:
        """The share of the light that reaches places so many m ahead."""
        return jnp.where((ahead > self.shade_from) & (ahead < self.shade_to), self.shade, 1.0)


def draw(eye: Eye, scene: Scene, motion: Motion) -> Float[np.ndarray, "time row_and_finer col_and_finer"]:
    """The frames in light that is not clipped, on a raster `_FINER` times as fine as the eye's."""
    degrees = None if eye.degrees_per_pixel is None else eye.degrees_per_pixel / _FINER
    finer = dataclasses.replace(eye, rows=_FINER * eye.rows, cols=_FINER * eye.cols, degrees_per_pixel=degrees)
    return np.asarray(in_pieces(_draw, finer, motion, scene))


def coarse(frames: Real[np.ndarray, "time row col"]) -> Float[np.ndarray, "time _row _col"]:
    """What each pixel of the eye sees of frames on the finer raster."""
    time, rows, cols = frames.shape
    return frames.reshape(time, rows // _FINER, _FINER, cols // _FINER, _FINER).mean(axis=(2, 4))


@functools.cache
def patterns() -> Float[np.ndarray, "pattern texel texel"]:
    """Pieces of scikit-image's photographs with mean 0 and standard deviation 1, which may be laid side by side."""
    pieces, chance = [], np.random.default_rng(0)
    for name in texture.PHOTOGRAPHS:
        whole = np.asarray(texture.read(name))
        for _ in range(_PER_PHOTOGRAPH):
            size = int(chance.integers(100, min(whole.shape)))
            top, left = (chance.integers(side - size + 1) for side in whole.shape)
            piece = np.asarray(
                jax.image.resize(
                    whole[top : top + size, left : left + size], (_TEXELS // 2, _TEXELS // 2), "linear", antialias=True
                )
            )
            whole_tile = np.concatenate([piece, piece[::-1]])
            whole_tile = np.concatenate([whole_tile, whole_tile[:, ::-1]], axis=1)
            pieces.append((whole_tile - whole_tile.mean()) / whole_tile.std())
    return np.array(pieces, np.float32)


@functools.cache
def _atlas() -> Float[np.ndarray, "blur pattern texel texel"]:
    """The patterns as rays see them that each take in the mean of 1, 2, 4... texels."""
    cycles = np.hypot(np.fft.fftfreq(_TEXELS)[:, None], np.fft.fftfreq(_TEXELS))
    spectra = np.fft.fft2(patterns())
    widths = 2.0 ** np.arange(_BLURRED) / np.sqrt(12)
    return np.array(
        [np.fft.ifft2(spectra * np.exp(-2 * (np.pi * cycles * width) ** 2)).real for width in widths], np.float32
    )


@traced_once
def _draw(eye: Eye, motion: Motion, scene: Scene) -> Float[Array, "time row col"]:
    azimuth, elevation = (jnp.radians(grid).astype(jnp.float32) for grid in eye.angles())
    rays = jnp.stack([jnp.sin(azimuth) * jnp.cos(elevation), jnp.sin(elevation), jnp.cos(azimuth) * jnp.cos(elevation)])
    from_below = jnp.linspace(1, 0, eye.rows, dtype=jnp.float32)[:, None]
    pixel = jnp.float32(np.radians(1 / eye.pixels_per_degree))
    atlas = jnp.asarray(_atlas())

    def frame(now: Motion):
        level = _frame(scene, now, _turned(rays, now.camera), pixel, atlas)
        bonnet = scene.bonnet_level * scene.light * scene.shaded(now.camera.ahead)
        return jnp.where(from_below < scene.bonnet, bonnet, level)

    return jax.lax.map(frame, motion)


def _turned(rays: Float[Array, "axis row col"], camera: Camera) -> Float[Array, "axis row col"]:
    x, y, z = rays
    c, s = jnp.cos(camera.roll), jnp.sin(camera.roll)
    x, y = c * x - s * y, s * x + c * y
    c, s = jnp.cos(camera.pitch), jnp.sin(camera.pitch)
    y, z = c * y + s * z, c * z - s * y
    c, s = jnp.cos(camera.yaw), jnp.sin(camera.yaw)
    return jnp.stack([c * x + s * z, y, c * z - s * x])


def _frame(scene: Scene, now: Motion, rays, pixel, atlas) -> Map:
    camera, (dx, dy, dz) = now.camera, rays
    level = _backdrop(scene, rays, pixel, atlas)

    def lit(level, reach, ahead):
        """A surface at a distance, by the light that reaches it so far ahead, and in the haze."""
        reach = jnp.clip(reach, 0, _FAR)
        own = level * (scene.light * scene.shaded(ahead) + scene.beam * jnp.exp(-reach / 12))
        return scene.sky + (own - scene.sky) * jnp.exp(-reach / scene.haze)

    down = jnp.where(dy < -1e-3, -camera.height / jnp.minimum(dy, -1e-3), _FAR)
    x, z = camera.right + down * dx, camera.ahead + down * dz
    ground = _pattern(scene.ground, x, z, pixel * down / jnp.maximum(-dy, 0.05), atlas)
    ground = jnp.maximum(ground, scene.lines * _markings(x, z, pixel * down))
    level = jnp.where(dy < -1e-3, lit(ground, down, z), level)

    reach_before = jnp.where(dy < -1e-3, down, _FAR)
    for side in (0, 1):
        reach = (scene.wall_at[side] - camera.right) / jnp.where(jnp.abs(dx) < 1e-3, 1e-3, dx)
        height, along = camera.height + reach * dy, camera.ahead + reach * dz
        wall = _pattern(scene.wall, along, height, pixel * reach / jnp.maximum(jnp.abs(dx), 0.05), atlas)
        glow = scene.lamps * _street_lamps(along, height, pixel * reach)
        seen = (reach > 0.1) & (reach < reach_before)
        level = jnp.where(seen & (height < scene.wall_tall), lit(wall, reach, along), level)
        level = jnp.where(seen, jnp.maximum(level, glow), level)

    from_far = jnp.argsort(-now.ahead)
    for i in range(OBJECTS):
        level = _with_object(scene.objects, now, from_far[i], rays, pixel, atlas, level, lit)
    return level


def _backdrop(scene: Scene, rays, pixel, atlas) -> Map:
    """The picture far away, up to the skyline, and the sky, a little brighter at the horizon."""
    dx, dy, dz = rays
    azimuth, elevation = jnp.arctan2(dx, dz), jnp.arcsin(jnp.clip(dy, -1, 1))
    picture = scene.light * _pattern(scene.far, azimuth, elevation, pixel, atlas)
    sky = scene.sky * (1 - 0.2 * jnp.clip(elevation, 0, 1))
    return jnp.where(elevation < scene.skyline, picture, sky)


def _with_object(objects: Objects, now: Motion, i, rays, pixel, atlas, behind, lit) -> Map:
    camera, (dx, dy, dz) = now.camera, rays
    reach = (now.ahead[i] - camera.ahead) / jnp.where(jnp.abs(dz) < 1e-3, 1e-3, dz)
    width, tall = objects.width[i], objects.tall[i]
    u = (camera.right + reach * dx - now.right[i]) / width
    v = (camera.height + reach * dy - now.height[i]) / tall
    power = objects.shape[i]
    outline = (jnp.abs(u) ** power + jnp.abs(v) ** power + 1e-9) ** (1 / power)
    sharp = jnp.minimum(width, tall) / jnp.maximum(pixel * reach, 1e-6)
    cover = jnp.where(reach > 0.02, jnp.clip((1 - outline) * sharp + 0.5, 0, 1), 0)
    own = jax.tree.map(lambda leaf: leaf[i], objects.surface)
    level = _pattern(own, u * width, v * tall, pixel * reach, atlas)
    level = lit(level * jnp.where(v < _UNDERSIDE, objects.underside[i], 1.0), reach, now.ahead[i])
    radius = jnp.maximum(0.12, pixel * reach)
    apart = jnp.hypot(jnp.abs(u) * width - 0.75 * width, v * tall + 0.3 * tall)
    level = jnp.maximum(level, objects.lamps[i] * jnp.clip(1.5 - apart / radius, 0, 1))
    return behind + cover * (level - behind)


def _pattern(surface: Surface, across, along, footprint, atlas) -> Map:
    """The grey level of a surface at a place, where a ray takes in the mean of a footprint; all in the grain's unit."""
    texel = surface.grain * (_GRAINS / _TEXELS)
    i, j = across / texel, along / texel
    left, below = jnp.floor(i), jnp.floor(j)
    a, b = i - left, j - below
    i, j = left.astype(int) % _TEXELS, below.astype(int) % _TEXELS
    blur = jnp.clip(jnp.round(jnp.log2(jnp.maximum(footprint / texel, 1))), 0, _BLURRED - 1).astype(int)
    tile = atlas[:, surface.pattern]
    i_next, j_next = (i + 1) % _TEXELS, (j + 1) % _TEXELS
    value = (1 - b) * ((1 - a) * tile[blur, j, i] + a * tile[blur, j, i_next]) + b * (
        (1 - a) * tile[blur, j_next, i] + a * tile[blur, j_next, i_next]
    )
    return jnp.maximum(surface.level * (1 + surface.contrast * value), 2.0)


def _markings(x, z, footprint) -> Map:
    """Dashes 3 m long every 9 m, at both sides of a lane of 3.5 m."""
    off = jnp.abs(jnp.abs(x) - 1.75)
    line = jnp.clip((0.12 + footprint / 2 - off) / footprint, 0, 1) * jnp.minimum(1, 0.24 / footprint)
    return line * ((z % 9) < 3)


def _street_lamps(along, height, footprint) -> Map:
    """One every 25 m, 6 m high."""
    apart = jnp.hypot((along + 12.5) % 25 - 12.5, height - 6)
    return jnp.clip(1.5 - apart / jnp.maximum(0.25, footprint), 0, 1)
