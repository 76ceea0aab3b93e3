"""Many robots at once, each in an arena of its own."""

from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import PRNGKeyArray

from lgmd2jax._arguments.checked import checked
from lgmd2jax._compute.batching import each_on_all_devices
from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._eye import Eye
from lgmd2jax.arena._camera import EYE, Scene
from lgmd2jax.arena._detectors import AbstractDetector
from lgmd2jax.arena._drive import SECONDS, Pose, Trip, Turn, drive
from lgmd2jax.arena._layout import Layout, random_layout


class Start(eqx.Module):
    """What a robot is put into, in arrays that stack: the scene, where it starts, and the key of its random numbers."""

    scene: Scene
    pose: Pose
    key: PRNGKeyArray

    @classmethod
    @checked
    def of(cls, seed: int) -> "Start":
        """The arena and the random numbers of a seed."""
        layout = random_layout(seed)
        pose = Pose(jnp.asarray(layout.start, jnp.float32), jnp.asarray(layout.heading, jnp.float32))
        return cls(Scene.of(layout), pose, jax.random.key(seed))

    @classmethod
    @checked
    def stacked(cls, seeds: Sequence[int]) -> "Start":
        """Those of several seeds."""
        return jax.tree.map(lambda *each: jnp.stack(each), *map(cls.of, seeds))


@checked
def run(
    detector: AbstractDetector, seeds: Sequence[int], *, turn: Turn = "random", seconds: float = SECONDS, eye: Eye = EYE
) -> tuple[list[Layout], Trip]:
    """A robot for each seed: the arenas, and the trips, stacked.

    The same seed gives the same arena, the same noise and the same turns, whatever the detector.
    """
    layouts = [random_layout(seed) for seed in seeds]
    return layouts, trips(detector, Start.stacked(seeds), turn=turn, seconds=seconds, eye=eye)


@checked
@traced_once
def trips(
    detector: AbstractDetector, starts: Start, *, turn: Turn = "random", seconds: float = SECONDS, eye: Eye = EYE
) -> Trip:
    """The trips of robots that start together, on all devices of this process."""
    arrays, static = eqx.partition(detector, eqx.is_array)
    count, devices = len(starts.key), jax.local_device_count()
    # Filled up with the last one, so that all devices have as many.
    padded = jax.tree.map(lambda leaf: leaf[np.minimum(np.arange(-(-count // devices) * devices), count - 1)], starts)

    def trip(arrays, start: Start) -> Trip:
        own = eqx.combine(arrays, static)
        return drive(own, start.scene, start.pose, start.key, turn=turn, seconds=seconds, eye=eye)

    return jax.tree.map(lambda leaf: leaf[:count], each_on_all_devices(trip, arrays, padded))
