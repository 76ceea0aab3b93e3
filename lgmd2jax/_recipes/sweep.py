"""A recipe of a sweep: what is swept and how it is drawn, read from a TOML file."""

import dataclasses
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lgmd2jax._eye import Eye
from lgmd2jax._handover.named import model_named
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._protocol.arguments import arguments, check_keys, keywords, section
from lgmd2jax._protocol.protocol import eye_of
from lgmd2jax._sweep.axes import read_grid
from lgmd2jax._sweep.responses import SUMMARIES, check_channels
from lgmd2jax._sweep.sweep import sweep
from lgmd2jax._words import nearest
from lgmd2jax.stimuli import FAMILIES

if TYPE_CHECKING:
    import xarray
    from distributed import Client

_KEYS = ("kind", "model", "eye", "family", "stimulus", "parameters", "channels", "figure")
_SPACINGS = {"linear": np.linspace, "log": np.geomspace}


@dataclasses.dataclass(frozen=True)
class SweepRecipe:
    """A sweep to be made.

    - `stimulus`: the arguments of the family, lists for axes.
    - `parameters`: of the model, likewise.
    - `channels`: of the response that are kept over time.
    - `value`: what the figure shows, None for no figure.
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
    """The recipe of a sweep that a TOML file holds.

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
    check_keys(table, _KEYS)
    family = table.get("family", "looming")
    if family not in FAMILIES:
        raise ValueError(f"family is {family!r}; choose {nearest(family, FAMILIES)}")
    names, folder = table.get("model", "preset:lgmd2"), path.parent.resolve()
    axes, fixed = {}, {}
    for name, value in section(table, "stimulus").items():
        swept = isinstance(value, list) or (isinstance(value, Mapping) and "from" in value)
        (axes if swept else fixed)[name] = _values(name, value) if swept else value
    check_keys(axes, keywords(FAMILIES[family]))
    figure = section(table, "figure", ("value", "index"))
    recipe = SweepRecipe(
        name=path.stem,
        model={name: model_named(name) for name in names} if isinstance(names, list) else model_named(names),
        eye=eye_of(section(table, "eye"), folder),
        family=family,
        stimulus=arguments(FAMILIES[family], fixed, folder) | axes,
        parameters={name: _values(name, value) for name, value in section(table, "parameters").items()},
        channels=check_channels(table.get("channels", ())),
        value=figure.get("value"),
        index=figure.get("index"),
    )
    _check_figure(recipe)
    return recipe


def _values(name: str, value: Any) -> Any:
    """A range as the numbers in it; all else as it is."""
    if not isinstance(value, Mapping):
        return value
    check_keys(value, ("from", "to", "count", "spacing"))
    spacing, count = value.get("spacing", "linear"), value.get("count")
    if spacing not in _SPACINGS:
        raise ValueError(f"{name} has spacing {spacing!r}; choose {nearest(spacing, _SPACINGS)}")
    if not ("to" in value and isinstance(count, int) and count > 0):
        raise ValueError(f"{name} is {dict(value)}; write {{ from = 5, to = 80, count = 20 }}")
    return _SPACINGS[spacing](value["from"], value["to"], count).tolist()


def _check_figure(recipe: SweepRecipe) -> None:
    """Refuse, before anything is computed, a figure that cannot be drawn."""
    if recipe.value is None:
        return
    if recipe.value not in SUMMARIES:
        raise ValueError(f"figure: value is {recipe.value!r}; choose {nearest(recipe.value, SUMMARIES)}")
    grid = read_grid(recipe.model, FAMILIES[recipe.family], recipe.eye, recipe.parameters, recipe.stimulus)
    sizes = {axis.name: len(axis.values) for axis in grid.axes if len(axis.values) > 1}
    if recipe.index is not None and sizes.pop(recipe.index, None) != 2:
        raise ValueError(f"figure: index is {recipe.index!r}, which is no axis of two values")
    if len(sizes) != 2:
        raise ValueError(f"figure: the axes are {', '.join(sizes)}; a surface has two, so fix others or leave it out")
