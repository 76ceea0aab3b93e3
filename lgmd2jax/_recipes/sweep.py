"""A recipe of a sweep: what is swept and how it is drawn, read from a TOML file."""

import dataclasses
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._handover.named import model_named
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._protocol.arguments import arguments
from lgmd2jax._protocol.protocol import eye_of
from lgmd2jax._sweep.axes import read_grid
from lgmd2jax._sweep.responses import check_channels
from lgmd2jax._sweep.sweep import sweep
from lgmd2jax.stimuli import FAMILIES

if TYPE_CHECKING:
    import xarray
    from distributed import Client


@dataclasses.dataclass(frozen=True)
class SweepRecipe:
    """A sweep to be made, as `load_recipe` reads it; `run` makes it.

    - `stimulus`: the arguments of the family; a list is an axis. `parameters`: those of the model, likewise.
    - `channels`: which channels of the response are kept over time.
    - `value`: what the figure shows; None for no figure.
    - `index`: an axis of two values a and b, along which the figure shows (a - b)/(a + b).
    """

    name: str
    model: AbstractNetwork | dict[str, AbstractNetwork]
    eye: Eye
    family: str
    stimulus: dict[str, Any]
    parameters: dict[str, Any]
    channels: tuple[str, ...]
    value: str | None
    index: str | None

    @checked
    def run(
        self, progress: bool = False, store: str | os.PathLike | None = None, client: "Client | None" = None
    ) -> "xarray.Dataset":
        """Make the sweep: `progress`, `store` and `client` as of `lgmd2jax.sweep`."""
        return sweep(
            self.model,
            FAMILIES[self.family],
            self.eye,
            parameters=self.parameters,
            channels=self.channels,
            store=store,
            client=client,
            progress=progress,
            **self.stimulus,
        )

    def thresholds(self) -> dict[str, float]:
        """What the figure's surface is compared with in the network: the spiking thresholds, of a surface of peaks."""
        swept = {"T_sp", "sigma_sp"} & set(self.parameters)
        if self.value != "peak" or self.index is not None or swept or not isinstance(self.model, AbstractNetwork):
            return {}
        return self.model.levels.by_count


def sweep_recipe(path: Path, table: dict[str, Any]) -> SweepRecipe:
    """The recipe of a sweep that a TOML file, whose form is checked, holds.

    ```toml
    kind = "sweep"
    model = "preset:lgmd2"      # or a file, or a shipped fit; a list is an axis
    family = "looming"

    [eye]                       # as in a protocol
    preset = "locust"

    [stimulus]                  # arguments of the family; a list is an axis, and so is a range
    contrast = [-0.9, -0.5]
    l_over_v = { from = 5, to = 80, count = 20, spacing = "log" }

    [parameters]                # of the model, likewise
    T_ffi = 20

    [figure]                    # of a sweep with two axes
    value = "peak"
    ```

    **Raises:** `ValueError`, which names the key, for what is not such a recipe; `FileNotFoundError`.
    """
    family = table.get("family", "looming")
    names, folder = table.get("model", "preset:lgmd2"), path.parent.resolve()
    axes, fixed = {}, {}
    for name, value in table.get("stimulus", {}).items():
        swept = isinstance(value, list) or (isinstance(value, Mapping) and "from" in value)
        (axes if swept else fixed)[name] = _values(f"stimulus.{name}", value) if swept else value
    parameters = table.get("parameters", {})
    figure = table.get("figure", {})
    recipe = SweepRecipe(
        name=path.stem,
        model={name: model_named(name) for name in names} if isinstance(names, list) else model_named(names),
        eye=eye_of(table["eye"]),
        family=family,
        stimulus=arguments(FAMILIES[family], fixed, folder) | axes,
        parameters={name: _values(f"parameters.{name}", value) for name, value in parameters.items()},
        channels=check_channels(table.get("channels", ())),
        value=figure.get("value"),
        index=figure.get("index"),
    )
    _check_figure(recipe)
    return recipe


def _values(place: str, value: Any) -> Any:
    """A range as the numbers in it; all else as it is."""
    if not isinstance(value, Mapping):
        return value
    first, last, count = value["from"], value["to"], value["count"]
    if value.get("spacing", "linear") == "linear":
        return np.linspace(first, last, count).tolist()
    if not first * last > 0:
        raise ValueError(f"{place} goes from {first:g} to {last:g} by equal factors; give two of one sign, or 'linear'")
    return np.geomspace(first, last, count).tolist()


def _check_figure(recipe: SweepRecipe) -> None:
    """Refuse, before anything is computed, a figure that cannot be drawn."""
    if recipe.value is None:
        return
    grid = read_grid(recipe.model, FAMILIES[recipe.family], recipe.eye, recipe.parameters, recipe.stimulus)
    sizes = {axis.name: len(axis.values) for axis in grid.axes if len(axis.values) > 1}
    if recipe.index is not None and sizes.pop(recipe.index, None) != 2:
        raise ValueError(f"figure: index is {recipe.index!r}, which is not an axis of two values")
    if len(sizes) != 2:
        raise ValueError(f"figure: the axes are {', '.join(sizes)}; a surface has two: fix others, or omit [figure]")
