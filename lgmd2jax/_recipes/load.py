"""Recipes by the kind that their file states: a fit to curves, a fit to labelled clips, a sweep."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from lgmd2jax._arguments.checked import checked
from lgmd2jax._files.catalogue import read_named
from lgmd2jax._recipes.fit import Recipe, fit_recipe
from lgmd2jax._recipes.sweep import SweepRecipe, sweep_recipe
from lgmd2jax._schemas.check import check, check_kind
from lgmd2jax._schemas.recipes import RECIPE
from lgmd2jax.alarms import AlarmRecipe
from lgmd2jax.alarms._recipe import alarm_recipe

AnyRecipe = Recipe | AlarmRecipe | SweepRecipe

_KINDS: Mapping[str, Callable[[Path, dict[str, Any]], AnyRecipe]] = {
    "fit": fit_recipe,
    "alarms": alarm_recipe,
    "sweep": sweep_recipe,
}


@checked
def load_recipe(source: str | Path) -> AnyRecipe:
    """Read a recipe from a TOML file, or a shipped one by its bare name, such as `"dcmd"`.

    **Returns:** what the file's `kind` says, each with a method `run`: for `"fit"`, or without a kind, a `Recipe`
    with its stimuli rendered; for `"alarms"` an `alarms.AlarmRecipe`; for `"sweep"` a `SweepRecipe`.

    **Raises:** `ValueError`, which names the file and the key, for what is not a recipe; `FileNotFoundError`.
    """
    return read_named(source, "fits", _recipe)


def _recipe(path: Path, table: dict[str, Any]) -> AnyRecipe:
    check_kind(table, "recipe")
    check(RECIPE, table)
    return _KINDS[table.get("kind", "fit")](path, table)
