"""`lgmd2jax sweep RECIPE`: the response over a grid of stimuli, parameters and models."""

import argparse
import time

from lgmd2jax._files.atomic import replaced
from lgmd2jax._files.folder import check_folder
from lgmd2jax._recipes.load import load_recipe
from lgmd2jax._recipes.sweep import SweepRecipe
from lgmd2jax.cli.all_cores import use_all_cores
from lgmd2jax.cli.recipe_results import folder_of

_STORE, _FIGURE = "sweep.zarr", "sweep.png"


def run(options: argparse.Namespace) -> None:
    """Make the sweep on all cores or accelerators, draw it, and name the folder."""
    start = time.monotonic()
    use_all_cores()
    recipe = load_recipe(options.recipe)
    if not isinstance(recipe, SweepRecipe):
        raise ValueError(f"{options.recipe} is the recipe of a fit; run lgmd2jax fit {options.recipe}")
    folder = folder_of(options, recipe.name)
    check_folder(folder, _FIGURE if (folder / _FIGURE).is_file() else f"{_STORE}/zarr.json")
    folder.mkdir(exist_ok=True)
    try:
        surface = recipe.run(progress=True, store=folder / _STORE)
    except KeyboardInterrupt:
        print(f"stopped; {folder / _STORE} keeps what is finished: run again to continue")
        raise SystemExit(130) from None
    if recipe.value is not None:
        from lgmd2jax._figures.sweep import surface_figure

        with replaced(folder / _FIGURE) as temporary:
            surface_figure(temporary, surface, recipe.value, recipe.index, recipe.thresholds(), recipe.name)
    sizes = " x ".join(f"{size} {name}" for name, size in surface.sizes.items())
    print(f"wrote {folder}/ ({sizes}) in {time.monotonic() - start:.0f} s")
