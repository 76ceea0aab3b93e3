"""The network on an accelerator, where JAX finds one: a large batch, and its share of the bandwidth of the memory."""

import dataclasses

import jax
import jax.numpy as jnp

from benchmarks import _library, _roofline
from benchmarks._task import SMALL, Size, film
from benchmarks._timing import time_together

BATCH, FRAMES = 1024, 60
_ELSEWHERE = 2**28  # numbers, beyond every cache


@dataclasses.dataclass(frozen=True)
class Accelerator:
    """Of hard responses to a batch, side by side.

    - `microseconds`: a frame a stimulus.
    - `bandwidth`: bytes a second of a sum of two large arrays.
    - `share`: of it, that the network would need if it passed over its maps once a frame.
    """

    device: str
    microseconds: float
    bandwidth: float
    share: float


def measure(rounds: int, batch: int = BATCH, size: Size = SMALL, numbers: int = _ELSEWHERE) -> Accelerator:
    """Measure the default device."""
    films = jnp.stack([jnp.asarray(film(size, FRAMES))] * batch)
    respond, add = _library.vmapped(), jax.jit(lambda a, b: a + b)
    large, other = jnp.ones(numbers, jnp.float32), jnp.zeros(numbers, jnp.float32)
    calls = {"batch": lambda: respond(films), "sum": lambda: jax.block_until_ready(add(large, other))}
    timings = time_together(calls, rounds)
    bandwidth = 3 * large.nbytes / timings["sum"].median
    needed = batch * FRAMES * size.rows * size.cols * _roofline.BYTES / bandwidth
    return Accelerator(
        jax.devices()[0].device_kind,
        1e6 * timings["batch"].median / batch / FRAMES,
        bandwidth,
        needed / timings["batch"].median,
    )
