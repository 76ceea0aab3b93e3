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
    """Where a robot drives, in arrays that stack: the scene, the robot's first pose, the key of its random numbers."""

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
        """The starts of several seeds, for `trips`."""
        return jax.tree.map(lambda *each: jnp.stack(each), *map(cls.of, seeds))


@checked
def run(
    detector: AbstractDetector, seeds: Sequence[int], *, turn: Turn = "random", seconds: float = SECONDS, eye: Eye = EYE
) -> tuple[list[Layout], Trip]:
    """Let a robot drive in the arena of each seed.

    The same seed gives the same arena, the same noise and the same turns, whatever the detector.

    ```python
    layouts, trips = lgmd.arena.run(lgmd.arena.detectors()["lgmd2"], range(20))
    print(lgmd.arena.Outcome.of(layouts, trips).collisions_per_metre)
    ```

    **Arguments:** `detector`: by which all robots drive. `turn`, `seconds`, `eye`: as of `drive`.

    **Returns:** the arenas, and the trips of all robots, stacked along the first axis.
    """
    layouts = [random_layout(seed) for seed in seeds]
    return layouts, trips(detector, Start.stacked(seeds), turn=turn, seconds=seconds, eye=eye)


@checked
@traced_once
def trips(
    detector: AbstractDetector, starts: Start, *, turn: Turn = "random", seconds: float = SECONDS, eye: Eye = EYE
) -> Trip:
    """The trips of robots from `Start.stacked`, stacked likewise, on all devices of this process.

    **Arguments:** as of `drive`.
    """
    arrays, static = eqx.partition(detector, eqx.is_array)
    count, devices = len(starts.key), jax.local_device_count()
    # Filled up with the last one, so that all devices have as many.
    padded = jax.tree.map(lambda leaf: leaf[np.minimum(np.arange(-(-count // devices) * devices), count - 1)], starts)

    def trip(arrays, start: Start) -> Trip:
        own = eqx.combine(arrays, static)
        return drive(own, start.scene, start.pose, start.key, turn=turn, seconds=seconds, eye=eye)

    return jax.tree.map(lambda leaf: leaf[:count], each_on_all_devices(trip, arrays, padded))
