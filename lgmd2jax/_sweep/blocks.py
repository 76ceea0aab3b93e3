"""Blocks: rectangles of the grid that are computed by one call and stored as one chunk, so that memory is bounded."""

import dataclasses
import math
from collections.abc import Mapping

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from lgmd2jax._compute.batching import each_on_all_devices
from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._sweep.axes import Grid, Setup
from lgmd2jax._sweep.responses import SUMMARIES, respond
from lgmd2jax._types import is_concrete

_PIXELS = 8e7  # times frames in a block, about a second on a core

Region = tuple[slice, ...]


@dataclasses.dataclass(frozen=True)
class Plan:
    """A sweep cut into blocks.

    - `time`: of the frames, in ms.
    - `chunk`: size of a block along each axis; blocks at the far ends are smaller.
    - `variables`: shape beyond the grid and dtype of each result.
    """

    grid: Grid
    channels: tuple[str, ...]
    time: np.ndarray
    chunk: tuple[int, ...]
    variables: dict[str, tuple[tuple[int, ...], np.dtype]]

    @property
    def blocks(self) -> tuple[int, ...]:
        """How many blocks there are along each axis."""
        return tuple(-(-size // step) for size, step in zip(self.grid.shape, self.chunk, strict=True))

    def numbers(self) -> range:
        """The blocks by number, the last axis fastest."""
        return range(math.prod(self.blocks))

    def region(self, number: int) -> Region:
        """Where a block lies in the grid."""
        place = np.unravel_index(number, self.blocks) if self.blocks else ()
        return tuple(
            slice(int(i) * step, min((int(i) + 1) * step, size))
            for i, step, size in zip(place, self.chunk, self.grid.shape, strict=True)
        )

    def size(self, number: int) -> int:
        """How many conditions a block holds."""
        return math.prod(part.stop - part.start for part in self.region(number))

    def compute(self, number: int) -> dict[str, np.ndarray]:
        """The results in a block, by all devices of this process."""
        region, devices, grid = self.region(number), jax.local_device_count(), self.grid
        shape = tuple(part.stop - part.start for part in region)
        count = math.prod(shape)
        inside = np.unravel_index(np.arange(count), shape)
        points = grid.at([part.start + place for part, place in zip(region, inside, strict=True)])
        # A block at a far end is filled up with its last condition, so that all have one shape and one program.
        lanes = devices * -(-math.prod(self.chunk) // devices)
        points = {name: np.pad(values, (0, lanes - count), mode="edge") for name, values in points.items()}
        results = _compute(grid.setup, points, self.channels)
        return {name: np.asarray(lane)[:count].reshape(*shape, *lane.shape[1:]) for name, lane in results.items()}


def plan_blocks(grid: Grid, channels: tuple[str, ...], block: int | None) -> Plan:
    """Cut a grid into blocks of at most `block` conditions, by default as many as take about a second.

    **Raises:** `ValueError` for a block that is not a positive whole number.
    """
    first = grid.at([np.zeros(1, int) for _ in grid.axes])
    times = []

    def rendered(point):
        stimulus = grid.setup.render(point)
        times.append(stimulus.time)
        return stimulus.frames

    point = {name: jnp.asarray(values[0]) for name, values in first.items()}
    frames = eqx.filter_eval_shape(rendered, point)
    results = eqx.filter_eval_shape(_traced_once, grid.setup, channels, point)
    if not is_concrete(times[0]):
        raise ValueError(
            "the window depends on what is swept; give the renderer start_ms and end_ms for the whole grid"
        )
    if block is None:
        block = max(int(_PIXELS / frames.size), 1) * jax.local_device_count()
    elif not isinstance(block, int) or block < 1:
        raise ValueError(f"block is {block!r}; give how many conditions a block holds, 1 or more")
    variables = {name: (results[name].shape, np.dtype(results[name].dtype)) for name in (*SUMMARIES, *channels)}
    return Plan(grid, channels, np.asarray(times[0]), _chunk(grid.shape, block), variables)


def _chunk(shape: tuple[int, ...], block: int) -> tuple[int, ...]:
    """Sizes along the axes of even blocks that hold at most `block` conditions: whole last axes, a part of one."""
    chunk, left = [], block
    for size in reversed(shape):
        parts = -(-size // min(size, max(left, 1)))
        chunk.append(-(-size // parts))
        left //= chunk[-1]
    return tuple(reversed(chunk))


_traced_once = eqx.filter_jit(respond)  # a plan asks for shapes alone; of another sweep like it they are known


@traced_once
def _compute(setup: Setup, points: Mapping[str, np.ndarray | Array], channels: tuple[str, ...]) -> dict[str, Array]:
    """The points of a block, one after the other on each device."""
    arrays, static = eqx.partition(setup, eqx.is_array)
    return each_on_all_devices(
        lambda arrays, point: respond(eqx.combine(arrays, static), channels, point), arrays, points
    )
