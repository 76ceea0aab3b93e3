"""From the model's membrane potential to the firing rate that a laboratory records."""

import dataclasses
import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float


class Observation(eqx.Module):
    """rate(t) = baseline + gain 2 (U'(t - latency) - .5), then smoothed as the recording was.

    **Arguments:** `baseline` and `gain` in spikes/s; `latency` in ms, of any fraction of a frame; `smoothing` in ms,
    the standard deviation of a Gaussian.
    """

    baseline: float | int = 0.0
    gain: float | int = 100.0
    latency: float | int = 0.0
    smoothing: float | int = 20.0

    def __check_init__(self):
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, str) or not math.isfinite(value):
                raise ValueError(f"{field.name} is {value!r}; give a finite number")
        for name in ("gain", "smoothing"):
            if getattr(self, name) <= 0:
                raise ValueError(f"{name} is {getattr(self, name)}; give a positive number")

    def __call__(
        self, smp_adapted: Float[Array | np.ndarray, " time"], time: Float[Array, " time"]
    ) -> Float[Array, " time"]:
        """The rate in spikes/s at the same times in ms. Before the first frame the cell is at rest."""
        late = jnp.interp(time - self.latency, time, smp_adapted, left=0.5)
        kernel = jax.nn.softmax(-0.5 * jnp.square((time[:, None] - time[None, :]) / self.smoothing), axis=1)
        return self.baseline + self.gain * 2 * (kernel @ (late - 0.5))
