"""What may drive the robot: a network, a threshold on the change of the image, or nothing."""

import abc
import dataclasses
from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.retina import magnitude
from lgmd2jax._network.sides import sides
from lgmd2jax._network.variants import at_eye
from lgmd2jax._types import Map, Scalar, cast
from lgmd2jax.arena._camera import EYE

Evidence = Float[Array, "2"]  # in the left third of the field and in the right one


class AbstractDetector(eqx.Module):
    """What sees frames, one after the other, and raises an alarm or none. One of your own is a subclass.

    `FrameDifference` is a short example. A detector is an `equinox.Module`: its numbers are arrays, and both methods
    are traced by JAX.
    """

    @abc.abstractmethod
    def rest(self, frame: Map) -> Any:
        """The state of a detector that has `frame` before it and saw no change."""

    @abc.abstractmethod
    def step(self, state: Any, frame: Map) -> tuple[Any, Bool[Array, ""], Evidence]:
        """The next state, whether there is an alarm, and the evidence for one in the left and right third of the field.

        The evidence decides only where to turn, with `turn="away"`.
        """


class NoDetector(AbstractDetector):
    """No alarm ever: the robot turns at contacts alone."""

    def rest(self, frame):
        return ()

    def step(self, state, frame):
        return (), jnp.zeros((), bool), jnp.zeros(2, frame.dtype)


@checked
class FrameDifference(AbstractDetector):
    """An alarm where the mean of abs(L(t) - L(t-1)) reaches a threshold in grey levels."""

    threshold: Scalar

    def rest(self, frame):
        return frame

    def step(self, state, frame):
        change = magnitude(frame - state)
        columns, third = change.sum(axis=0), frame.shape[1] // 3
        evidence = jnp.stack([columns[:third].sum(), columns[-third:].sum()])
        return frame, change.mean() >= self.threshold, evidence


@checked
class NetworkDetector(AbstractDetector):
    """The alarm of a network, which `of` takes to the robot's camera. The evidence of a side is its part of MP."""

    network: AbstractNetwork

    @classmethod
    def of(cls, network: AbstractNetwork, eye: Eye = EYE) -> "NetworkDetector":
        """The network for the robot's camera, in float32; one without an eye is taken to be meant for it."""
        adapted = dataclasses.replace(network, eye=eye) if network.eye is None else at_eye(network, eye)
        return cls(cast(adapted, jnp.float32))

    def rest(self, frame):
        return self.network.init(frame)

    def step(self, state, frame):
        state, response = self.network.step(state, frame, record=sides)
        left, _, right = response.recorded.mp
        return state, response.collision >= 0.5, jnp.stack([left, right])
