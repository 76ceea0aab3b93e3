"""The responses over a grid, in JAX alone: rendered, answered and summed up one condition after the other."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._channels import RESPONSE
from lgmd2jax._compute.batching import each
from lgmd2jax._eye import Eye
from lgmd2jax._network.abstract import Response
from lgmd2jax._sweep.axes import Models, Setup, read_grid
from lgmd2jax._words import nearest

# One number a response, with unit and meaning.
SUMMARIES = {
    "peak": ("1", "peak of the membrane potential U' (eq. 15)"),
    "peak_time": ("ms", "time of the peak; none where U' never leaves rest"),
    "spike_count": ("spikes", "spikes in all"),
    "first_alarm": ("ms", "time of the first alarm; none where there is none"),
    "integral": ("ms", "integral over time of U' above rest"),
}


def summaries(response: Response, time: Float[Array, " time"]) -> dict[str, Float[Array, ""]]:
    """What `SUMMARIES` names, of one response."""
    u, alarm = response.smp_adapted, response.collision >= 0.5
    top, nothing = jnp.argmax(u), jnp.nan
    return {
        "peak": u[top],
        "peak_time": jnp.where(u[top] > 0.5, time[top], nothing),
        "spike_count": response.spikes.sum(),
        "first_alarm": jnp.where(jnp.any(alarm), time[jnp.argmax(alarm)], nothing),
        "integral": jnp.sum(u - 0.5) * (time[1] - time[0]),
    }


def respond(setup: Setup, channels: Sequence[str], point: Mapping[str, Array]) -> dict[str, Array]:
    """Summaries and channels at one point."""
    stimulus = setup.render(point)
    response = setup.model_at(point)(stimulus.frames, stimulus.fps)
    return summaries(response, stimulus.time) | {name: getattr(response, name) for name in channels}


def check_channels(channels: Sequence[str]) -> tuple[str, ...]:
    """The names, each once.

    **Raises:** `ValueError` for a name that is no channel.
    """
    for name in channels:
        if name not in RESPONSE:
            raise ValueError(f"channels has {name!r}; choose {nearest(name, RESPONSE)}")
    return tuple(dict.fromkeys(channels))


@checked
def surfaces(
    model: Models,
    renderer: Callable,
    eye: Eye,
    *,
    parameters: Mapping[str, Any] | None = None,
    channels: Sequence[str] = (),
    **arguments: Any,
) -> dict[str, Array]:
    """What `sweep` computes, as plain JAX arrays of the grid's shape, in one program: for `jax.grad`, `jit` and `vmap`.

    ```python
    def mean_peak(theta2):
        model = LGMD2(Parameters(theta2=theta2), Soft())
        return surfaces(model, stimuli.looming, eye, contrast=[-0.9, -0.5], l_over_v=[10, 40])["peak"].mean()
    jax.grad(mean_peak)(3.0)
    ```

    **Arguments:** as for `sweep`; the model may be traced, the axes may not.

    **Raises:** `ValueError` as `sweep`.
    """
    channels = check_channels(channels)
    grid = read_grid(model, renderer, eye, parameters, arguments)
    places = np.unravel_index(np.arange(np.prod(grid.shape)), grid.shape)
    points = jax.tree.map(jnp.asarray, grid.at(places))
    results = each(lambda point: respond(grid.setup, channels, point), points)
    return {name: values.reshape(*grid.shape, *values.shape[1:]) for name, values in results.items()}
