"""Many robots at once, each in an arena of its own."""

import functools
from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp

from lgmd2jax.arena._camera import Scene
from lgmd2jax.arena._detectors import AbstractDetector
from lgmd2jax.arena._drive import SECONDS, Pose, Trip, Turn, drive
from lgmd2jax.arena._layout import Layout, random_layout


class Start(eqx.Module):
    """What a robot is put into, in arrays that stack: the scene, where it starts, and the key of its chances."""

    scene: Scene
    pose: Pose
    key: jax.Array

    @classmethod
    def of(cls, seed: int) -> "Start":
        """The arena and the chances of a seed."""
        layout = random_layout(seed)
        pose = Pose(jnp.asarray(layout.start, jnp.float32), jnp.asarray(layout.heading, jnp.float32))
        return cls(Scene.of(layout), pose, jax.random.key(seed))

    @classmethod
    def stacked(cls, seeds: Sequence[int]) -> "Start":
        """Those of several seeds."""
        return jax.tree.map(lambda *each: jnp.stack(each), *map(cls.of, seeds))


def run(
    detector: AbstractDetector, seeds: Sequence[int], *, turn: Turn = "random", seconds: float = SECONDS
) -> tuple[list[Layout], Trip]:
    """A robot for each seed: the arenas, and the trips, stacked.

    The same seed gives the same arena, the same noise and the same turns, whatever the detector.
    """
    return [random_layout(seed) for seed in seeds], trips(detector, Start.stacked(seeds), turn=turn, seconds=seconds)
