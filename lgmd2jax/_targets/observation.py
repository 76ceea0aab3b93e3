"""From the model's membrane potential to the firing rate that a laboratory records."""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._network.parameter_set import Symbol, check_domains, declared, declares, scalar


def _number(name: str) -> Callable[[Any], Array]:
    """Makes a scalar of what is given, or says that `name` is none."""

    def converted(value):
        try:
            return scalar(value)
        except ValueError:
            raise ValueError(f"{name} is {value!r}; give a number") from None

    return converted


@checked
class Observation(eqx.Module):
    """rate(t) = baseline + gain 2 (U'(t - latency) - .5), then smoothed as the recording was.

    **Arguments:** one floating scalar each, so that they can be fitted like the network's parameters.

    - `baseline`: rate at rest, in spikes/s.
    - `gain`: rate above it at the highest potential, U' = 1, in spikes/s.
    - `latency`: from the potential to the record, in ms, of any fraction of a frame.
    - `smoothing`: standard deviation of the Gaussian by which the recorded spikes were smoothed, in ms.

    **Raises:** `ValueError` for a value outside its domain, when the value is concrete (not traced).
    """

    baseline: Float[Array, ""] = eqx.field(
        default=0.0,
        converter=_number("baseline"),
        metadata=declares(
            "firing rate at rest", "spikes/s", "[0, inf)", (0.0, 50.0), source="DCMD recordings rest at 2 to 7"
        ),
    )
    gain: Float[Array, ""] = eqx.field(
        default=100.0,
        converter=_number("gain"),
        metadata=declares(
            "firing rate above rest at the highest potential",
            "spikes/s",
            "(0, inf)",
            (1.0, 500.0),
            source="DCMD recordings peak at 80 to 100; single trials at a few hundred",
            scale="log",
        ),
    )
    latency: Float[Array, ""] = eqx.field(
        default=0.0,
        converter=_number("latency"),
        metadata=declares(
            "delay from the potential to the record",
            "ms",
            "[0, inf)",
            (0.0, 120.0),
            source="15 to 35 of the cell (Gabbiani et al. 1999), and that of screen and recorder",
        ),
    )
    smoothing: Float[Array, ""] = eqx.field(
        default=20.0,
        converter=_number("smoothing"),
        metadata=declares(
            "standard deviation of the recording's Gaussian kernel",
            "ms",
            "(0, inf)",
            (5.0, 100.0),
            source="20 is usual for LGMD and DCMD",
            scale="log",
        ),
    )

    def __check_init__(self):
        check_domains(self)

    @checked
    def __call__(
        self, smp_adapted: Float[Array | np.ndarray, " time"], time: Float[Array | np.ndarray, " time"]
    ) -> Float[Array, " time"]:
        """The rate in spikes/s at the same times in ms. Before the first frame the cell is at rest.

        The kernel weighs the frames that there are, so that a constant rate stays constant up to the clip's ends.
        """
        time, smp_adapted = jnp.asarray(time), jnp.asarray(smp_adapted)
        # The cell comes from rest within one frame, so that the rate has no jump as the latency passes a frame.
        before = 2 * time[:1] - time[1:2]
        late = jnp.interp(
            time - self.latency,
            jnp.concatenate([before, time]),
            jnp.concatenate([jnp.full_like(smp_adapted[:1], 0.5), smp_adapted]),
        )
        kernel = jax.nn.softmax(-0.5 * jnp.square((time[:, None] - time[None, :]) / self.smoothing), axis=1)
        return self.baseline + self.gain * 2 * (kernel @ (late - 0.5))


def observation_symbols() -> dict[str, Symbol]:
    """What is known of each parameter of an `Observation`, by name."""
    return declared(Observation)
