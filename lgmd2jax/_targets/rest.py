"""Rest, and a brief departure from it."""

import dataclasses
import math

import numpy as np

from lgmd2jax._arguments.checked import checked
from lgmd2jax._channels import TARGETS, Channel
from lgmd2jax._targets.target import Target
from lgmd2jax.stimuli import Stimulus


def resting(channel: Channel, rest: float | int | None) -> float:
    """The value at rest, in the unit of the channel: `rest` where it is given, else the network's own.

    **Raises:** `ValueError` for a rate whose rest is not given, and for a rest that is not finite.
    """
    value = TARGETS[channel].rest if rest is None else float(rest)
    if value is None:
        raise ValueError(f"rest is missing; a {channel} has no resting value of its own, so give it")
    if not math.isfinite(value):
        raise ValueError(f"rest is {rest}; give a finite number")
    return value


@checked
@dataclasses.dataclass(frozen=True)
class Rest:
    """The resting value throughout.

    **Arguments:**

    - `channel`: as of a `Target`.
    - `rest`: the value, in the unit of the channel; None for the network's own: .5 for the potentials, 0 for spikes.

    **Raises:** `ValueError` for an unknown channel, and for a rate whose rest is not given.
    """

    channel: Channel = "smp_adapted"
    rest: float | int | None = None

    def __post_init__(self):
        resting(self.channel, self.rest)

    @checked
    def on(self, stimulus: Stimulus) -> Target:
        """The target at the frames of the stimulus."""
        return Target(self.channel, np.full(len(stimulus.time), resting(self.channel, self.rest))).on(stimulus)


@checked
@dataclasses.dataclass(frozen=True, kw_only=True)
class Onset:
    """A response that starts at once and decays exponentially: rest + peak exp(-(t - at)/decay) from t = at on.

    **Arguments:**

    - `peak`: the first value above rest, in the unit of the channel.
    - `decay_ms`: time constant of the decay.
    - `at_ms`: when it starts; 0 is the onset in all stimuli but those whose 0 is the collision.
    - `channel`, `rest`: as of `Rest`.

    **Raises:** `ValueError` for a decay that is not positive, for what is not finite, and as `Rest`.
    """

    peak: float | int
    decay_ms: float | int
    at_ms: float | int = 0.0
    channel: Channel = "smp_adapted"
    rest: float | int | None = None

    def __post_init__(self):
        resting(self.channel, self.rest)
        for name in ("peak", "at_ms"):
            if not math.isfinite(getattr(self, name)):
                raise ValueError(f"{name} is {getattr(self, name)}; give a finite number")
        if not (math.isfinite(self.decay_ms) and self.decay_ms > 0):
            raise ValueError(f"decay_ms is {self.decay_ms} ms; give a positive number")

    @checked
    def on(self, stimulus: Stimulus) -> Target:
        """The target at the frames of the stimulus.

        **Raises:** `ValueError` for a start outside of the stimulus.
        """
        time = np.asarray(stimulus.time, dtype=float)
        if not time[0] <= self.at_ms <= time[-1]:
            raise ValueError(
                f"at_ms is {self.at_ms:g}, outside of the stimulus, which covers {time[0]:g} to {time[-1]:g} ms"
            )
        since = time - self.at_ms
        response = np.where(since >= 0, self.peak * np.exp(-np.maximum(since, 0) / self.decay_ms), 0.0)
        return Target(self.channel, resting(self.channel, self.rest) + response).on(stimulus)
