"""A sweep: what the network answers over a grid of conditions."""

import contextlib
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._files.lock import locked
from lgmd2jax._sweep.axes import Models, read_grid
from lgmd2jax._sweep.blocks import plan_blocks
from lgmd2jax._sweep.cluster import spread
from lgmd2jax._sweep.responses import check_channels
from lgmd2jax._sweep.store import Memory, Store, is_complete, need

if TYPE_CHECKING:
    import xarray
    from distributed import Client


@checked
def sweep(
    model: Models,
    renderer,
    eye: Eye,
    *,
    parameters: Mapping[str, Any] | None = None,
    channels: Sequence[str] = (),
    store: str | os.PathLike | None = None,
    client: "Client | None" = None,
    block: int | None = None,
    progress: bool = False,
    **arguments: Any,
) -> "xarray.Dataset":
    """The response over a grid of stimuli, parameters and models, as labelled arrays.

    ```python
    surface = sweep(LGMD2(), stimuli.looming, eye, contrast=[-0.9, -0.5, -0.1], l_over_v=[10, 20, 40, 80])
    surface.peak.sel(contrast=-0.9)
    sweep(LGMD2(), stimuli.looming, eye, parameters={"theta2": [1, 2, 4]}, contrast=[-0.9, 0.2])
    sweep({"dark": dark, "light": light}, stimuli.grating, eye, temporal_frequency=[1, 2, 5], store="gratings.zarr")
    ```

    Blocks of the grid are rendered, answered and summed up by one compiled program, on all devices of this process, or
    on the workers of `client`.

    **Arguments:**

    - `model`: an `LGMD2`; a list or dictionary of models of one structure, or a stack of them, gives the axis `model`.
    - `renderer`: a family of `lgmd2jax.stimuli`, or any function of an eye and keywords that returns a `Stimulus`;
      such a function is called for the corners of the grid first.
    - `eye`: the sampling that stimuli are rendered for.
    - `parameters`: values of model parameters; a list is an axis.
    - `channels`: of the response that are kept over time: `mp`, `ffi`, `smp`, `smp_adapted`, `spikes`, `collision`.
    - `store`: a folder for the results, in Zarr; the same sweep goes on there where it was stopped or killed. The
      arrays of the result are then read as they are looked at. By default they are in memory.
    - `client`: a `dask.distributed.Client`, whose workers see the folder of the store.
    - `block`: conditions that are computed at once and stored as one chunk; by default about a second's work.
    - `progress`: whether to show a bar.
    - `arguments`: of the renderer; a list of numbers is an axis, all else stays fixed. One window holds for the whole
      grid: `start_ms` and `end_ms`, or what covers the default ones of all corners of the grid.

    **Returns:** `peak`, `peak_time`, `spike_count`, `first_alarm` and `integral` over the axes (models, parameters and
    stimulus, in the order given), and the channels over these and time; units are in the attributes.

    **Raises:** `ValueError` for names that nothing takes, axes that are empty or not finite, values that the renderer
    refuses, a store of another sweep or in use by another process, and a disk that is full.
    """
    need("xarray", extra="sweep")
    grid = read_grid(model, renderer, eye, parameters, arguments)
    blocks = plan_blocks(grid, check_channels(channels), block)
    with contextlib.nullcontext() if store is None or is_complete(blocks, store) else locked(store):
        results = Memory(blocks) if store is None else Store(blocks, store)
        left = results.missing()
        total = sum(blocks.size(number) for number in blocks.numbers())
        done = total - sum(map(blocks.size, left))
        with tqdm(desc="sweep", total=total, initial=done, disable=not progress, leave=False) as bar:
            local = ((number, blocks.compute(number)) for number in left)
            for number, block_results in local if client is None else spread(blocks, left, client, store):
                if block_results is not None:
                    results.write(number, block_results)
                bar.update(blocks.size(number))
    return results.dataset()
