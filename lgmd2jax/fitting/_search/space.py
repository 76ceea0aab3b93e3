"""The unit box that a fit searches: a model at each of its points, and how far that is from what is wanted."""

import abc
import dataclasses
from typing import Generic

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._network.abstract import AnyNetwork
from lgmd2jax._network.thresholds import Hard, Soft, Thresholds
from lgmd2jax._targets.observation import Observation
from lgmd2jax.fitting._free import Free


class Space(eqx.Module, Generic[AnyNetwork]):
    """What is free of a model and of how it is observed.

    Points `z` lie in the unit box, an entry a free parameter. A temperature of None stands for the model's own
    thresholds; a number softens them.
    """

    model: AnyNetwork
    observation: Observation
    free: Free

    @property
    def pixel_indices(self) -> tuple[int, ...]:
        """The free parameters that the pixels need."""
        return tuple(i for i, parameter in enumerate(self.free.structure) if parameter.symbol.stage == "pixels")

    @property
    def cell_indices(self) -> tuple[int, ...]:
        """The free parameters of the cell and of the observation."""
        return tuple(i for i in range(len(self.free)) if i not in self.pixel_indices)

    def at(
        self, z: Float[Array | np.ndarray, " free"], temperature: Float[Array, ""] | None = None
    ) -> tuple[AnyNetwork, Observation]:
        """The model and the observation at a point."""
        parameters, observation = self.free.insert(self.model.parameters, self.observation, z)
        thresholds = self.model.thresholds if temperature is None else soften(self.model.thresholds, temperature)
        return dataclasses.replace(self.model, parameters=parameters, thresholds=thresholds), observation

    @abc.abstractmethod
    def residuals(
        self, z: Float[Array | np.ndarray, " free"], temperature: Float[Array, ""] | None
    ) -> Float[Array, " n"]:
        """What a descent makes small."""

    @property
    @abc.abstractmethod
    def scale(self) -> float:
        """The norm that the residuals have where every difference from what is wanted is 1, in its own unit."""


def soften(thresholds: Thresholds, temperature: Float[Array, ""]) -> Thresholds:
    """The soft thresholds that approximate these, or these at another temperature."""
    if isinstance(thresholds, Hard):
        return Soft(temperature)
    return eqx.tree_at(lambda soft: soft.temperature, thresholds, temperature)
