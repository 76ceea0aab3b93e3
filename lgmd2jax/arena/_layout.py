"""The arena: a square of walls, cylinders in it, dark patterns on both, and where the robot starts.

The paper gives 110 x 110 cm, white walls and obstacles "marked with densely distributed dark patterns", 10 to 20
obstacles and a robot of 4 cm. Sizes of obstacles and patterns are this project's choice.
"""

import dataclasses
import math

import numpy as np
from jaxtyping import Bool, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax.stimuli._camera import FLICKER, FLICKER_HZ, NOISE

SIDE_CM = 110.0
ROBOT_RADIUS_CM = 2.0
FEWEST, MOST = 10, 20  # obstacles
OBSTACLE_RADIUS_CM = 2.5, 4.0
GAP_CM = 8.0  # at least, between obstacles and from them to the walls: two robots pass
HEIGHT_CM = 20.0  # of walls and obstacles

PATCH_CM = 2.0
WHITE, DARK = 200.0, (60.0, 140.0)  # grey levels
DARK_SHARE = 0.5  # of the patches
BANDS = round(HEIGHT_CM / PATCH_CM)
WALL_PATCHES = round(4 * SIDE_CM / PATCH_CM)
OBSTACLE_PATCHES = math.ceil(2 * math.pi * OBSTACLE_RADIUS_CM[1] / PATCH_CM)
PATCHES = WALL_PATCHES + MOST * OBSTACLE_PATCHES


@dataclasses.dataclass(frozen=True)
class Layout:
    """One arena; the origin is a corner, lengths are in cm.

    - `centres`, `radii`: of the obstacles.
    - `patches`: grey levels by height, from the floor up, and along all surfaces in a row: the four walls (y = 0,
      x = 110, y = 110, x = 0), then `OBSTACLE_PATCHES` for each obstacle.
    - `start`: where the robot's centre starts, and `heading`, in radians from the x axis to the y axis.
    - `noise`: standard deviation of a pixel of the camera, in grey levels. `flicker`: of the light, as a share of its
      strength; `flicker_hz`, and `flicker_phase` in radians at the first frame.
    """

    centres: Float[np.ndarray, "obstacle 2"]
    radii: Float[np.ndarray, " obstacle"]
    patches: Float[np.ndarray, "band patch"]
    start: Float[np.ndarray, "2"]
    heading: float
    noise: float
    flicker: float
    flicker_hz: float
    flicker_phase: float

    def free(self, places: Float[np.ndarray, "*place 2"]) -> Bool[np.ndarray, "*place"]:
        """Whether the robot's centre may be at each place."""
        inside = np.all((places >= ROBOT_RADIUS_CM) & (places <= SIDE_CM - ROBOT_RADIUS_CM), axis=-1)
        distance = np.linalg.norm(places[..., None, :] - self.centres, axis=-1)
        return inside & np.all(distance >= self.radii + ROBOT_RADIUS_CM, axis=-1)


@checked
def random_layout(seed: int) -> Layout:
    """The arena of a seed: 10 to 20 obstacles, patterns, and a start from which the robot can move."""
    chance = np.random.default_rng(seed)
    count = int(chance.integers(FEWEST, MOST + 1))
    centres, radii = np.empty((0, 2)), np.empty(0)
    while len(radii) < count:
        radius = chance.uniform(*OBSTACLE_RADIUS_CM)
        centre = chance.uniform(radius + GAP_CM, SIDE_CM - radius - GAP_CM, 2)
        if np.all(np.linalg.norm(centres - centre, axis=1) >= radii + radius + GAP_CM):
            centres, radii = np.vstack([centres, centre]), np.append(radii, radius)
    dark = chance.random((BANDS, PATCHES)) < DARK_SHARE
    patches = np.where(dark, chance.uniform(*DARK, (BANDS, PATCHES)), WHITE)
    start = np.zeros(2)
    while _margin(start, centres, radii) < ROBOT_RADIUS_CM + GAP_CM / 2:
        start = chance.uniform(0, SIDE_CM, 2)
    return Layout(
        centres,
        radii,
        patches,
        start,
        heading=chance.uniform(-math.pi, math.pi),
        noise=chance.uniform(*NOISE),
        flicker=chance.uniform(*FLICKER),
        flicker_hz=float(chance.choice(FLICKER_HZ)),
        flicker_phase=chance.uniform(-math.pi, math.pi),
    )


def _margin(place: Float[np.ndarray, "2"], centres: Float[np.ndarray, "obstacle 2"], radii: np.ndarray) -> float:
    """From a place to the nearest surface, in cm."""
    return min((np.linalg.norm(centres - place, axis=1) - radii).min(), place.min(), (SIDE_CM - place).min())
