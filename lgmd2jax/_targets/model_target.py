"""The response of another model as a target: twins, and hand-overs from one circuit to another."""

import dataclasses
import math
import zlib

import jax
import numpy as np

from lgmd2jax._arguments.checked import checked
from lgmd2jax._channels import Channel
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._targets.observation import Observation
from lgmd2jax._targets.target import Target
from lgmd2jax._types import Key, check_key
from lgmd2jax.stimuli import Stimulus


@checked
@dataclasses.dataclass(frozen=True, kw_only=True)
class ModelTarget:
    """What a model answers to the same stimulus.

    **Arguments:**

    - `model`: with hard or soft thresholds.
    - `channel`: as of a `Target`.
    - `observation`: from the potential to the rate, for the channel `"rate"` and for no other.
    - `noise`: standard deviation of Gaussian noise added to every frame, in the unit of the channel; it is then the
      error of the target.
    - `key`: of the noise. Stimuli of other names and other channels have other noise under the same key.

    **Raises:** `ValueError` for an unknown channel, a rate without an observation and an observation without a rate,
    noise that is negative or not finite, and noise without a key.
    """

    model: AbstractNetwork
    channel: Channel = "smp_adapted"
    observation: Observation | None = None
    noise: float | int = 0.0
    key: Key | None = None

    def __post_init__(self):
        if (self.observation is None) == (self.channel == "rate"):
            wanted = "needs an observation" if self.channel == "rate" else "takes no observation; that is for 'rate'"
            raise ValueError(f"channel is {self.channel!r}, which {wanted}")
        if not (math.isfinite(self.noise) and self.noise >= 0):
            raise ValueError(f"noise is {self.noise}; give 0 or more")
        if self.key is not None:
            check_key(self.key)
        if self.noise and self.key is None:
            raise ValueError(f"noise is {self.noise:g} without a key; give key=jax.random.key(0)")

    @checked
    def on(self, stimulus: Stimulus) -> Target:
        """The target at the frames of the stimulus."""
        response = self.model(stimulus.frames, stimulus.fps)
        if self.observation is not None:
            curve = self.observation(response.smp_adapted, stimulus.time)
        else:
            curve = getattr(response, self.channel)
        if not self.noise or self.key is None:
            return Target(self.channel, np.asarray(curve)).on(stimulus)
        key = jax.random.fold_in(self.key, zlib.crc32(f"{stimulus.name}/{self.channel}".encode()))
        noise = self.noise * np.asarray(jax.random.normal(key, curve.shape))
        return Target(self.channel, np.asarray(curve) + noise, error=self.noise).on(stimulus)
