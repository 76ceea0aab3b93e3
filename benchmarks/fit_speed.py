"""How much faster fits are with the library's own derivative of the pixel stage than with plain differentiation.

python -m benchmarks.fit_speed twin lgmd2

Each recipe is fitted in a fresh process, with XLA set up as by the command, once with the library's derivative of the
pixel stage and once with plain differentiation of the same scan; then once more in the same process, which compiles
nothing. All see the same starts.
"""

import argparse
import subprocess
import sys
import time

import jax

from lgmd2jax._compute import xla as _xla
from lgmd2jax._network.pixels import Pixels
from lgmd2jax._recipes.load import load_recipe

RULES = {"exact": Pixels.over, "plain": Pixels.plain}


def seconds(recipe: str, rule: str) -> list[float]:
    """Of a whole fit in a process of its own, and of the same once more."""
    command = [sys.executable, "-m", "benchmarks.fit_speed", recipe, "--rule", rule]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return [float(it) for it in printed.split()]


def _fit_here(recipe: str) -> float:
    began = time.monotonic()
    load_recipe(recipe).run()
    return time.monotonic() - began


def main() -> None:
    """Time the fits and print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recipes", nargs="+", metavar="RECIPE", help="by name or path")
    parser.add_argument("--rule", choices=RULES, help="only this one, here, and only its seconds are printed")
    options = parser.parse_args()
    _xla.set_flags()
    if options.rule:
        jax.config.update("jax_enable_x64", True)
        Pixels.over = RULES[options.rule]
        print(_fit_here(options.recipes[0]), _fit_here(options.recipes[0]))
        return
    print("recipe                  exact s   plain s   ratio")
    for recipe in options.recipes:
        times = zip(("compiled first", "once more"), seconds(recipe, "exact"), seconds(recipe, "plain"), strict=True)
        for how, exact, plain in times:
            print(f"{recipe:8}{how:14}{exact:9.1f}{plain:10.1f}{plain / exact:8.2f}", flush=True)


if __name__ == "__main__":
    main()
