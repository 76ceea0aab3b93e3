"""What may drive the robot: a network, a threshold on the change of the image, or nothing."""

import abc
from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.pixels import Layers
from lgmd2jax._network.retina import magnitude
from lgmd2jax._network.yue_rind import YueRindLayers
from lgmd2jax._types import Map, Scalar

Sides = Float[Array, "2"]  # evidence in the left half of the field and in the right one


class AbstractDetector(eqx.Module):
    """What sees a frame and raises an alarm or none."""

    @abc.abstractmethod
    def rest(self, frame: Map) -> Any:
        """The state of a detector that has `frame` before it and saw no change."""

    @abc.abstractmethod
    def step(self, state: Any, frame: Map) -> tuple[Any, Bool[Array, ""], Sides]:
        """The next state, the alarm, and the evidence of both sides."""


class NoDetector(AbstractDetector):
    """Never an alarm: the robot learns by contact."""

    def rest(self, frame):
        return ()

    def step(self, state, frame):
        return (), jnp.zeros((), bool), jnp.zeros(2, frame.dtype)


class FrameDifference(AbstractDetector):
    """An alarm where the mean of abs(L(t) - L(t-1)) reaches a threshold in grey levels."""

    threshold: Scalar

    def rest(self, frame):
        return frame

    def step(self, state, frame):
        change = magnitude(frame - state)
        return frame, change.mean() >= self.threshold, _halves(change)


class NetworkDetector(AbstractDetector):
    """The alarm of a network. The evidence of a side is its part of MP."""

    network: AbstractNetwork

    def rest(self, frame):
        return self.network.init(frame)

    def step(self, state, frame):
        state, response = self.network.step(state, frame, record=_sides)
        return state, response.collision >= 0.5, response.recorded


def _sides(layers: Layers | YueRindLayers) -> Sides:
    summed = layers.s_gated if isinstance(layers, Layers) else layers.g_kept
    return _halves(magnitude(summed))


def _halves(evidence: Map) -> Sides:
    columns, middle = evidence.sum(axis=0), evidence.shape[1] // 2
    return jnp.stack([columns[:middle].sum(), columns[-middle:].sum()])
