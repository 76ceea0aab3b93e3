"""How much better circuits with additional mechanisms fit the same data than the circuit without them.

python -m benchmarks.circuits fits/circuits_dcmd.toml -o results/circuits_dcmd
python -m benchmarks.circuits fits/circuits_lgmd2.toml -o results/circuits_lgmd2

The fits go into folders of the circuits' names; those that are there already are kept. Circuits with a lag are left out
where the latency of the observation is free, since rates tell the two apart by nothing.
"""

import argparse
from pathlib import Path

import lgmd2jax as lgmd
from lgmd2jax.cli import main as run

CIRCUITS = {
    "plain": (),
    "A": ("size",),
    "B": ("shunt",),
    "B+D": ("shunt", "membrane"),
    "A+B": ("size", "shunt"),
    "A+B+lag": ("size", "shunt", "lag"),
    "all": ("size", "shunt", "lag", "membrane"),
}


def main() -> int:
    """Fit each circuit, and compare them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recipe", help="of a fit to curves")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the folder for the fits and what they say")
    parser.add_argument("--properties", action="store_true", help="also count the response properties of each circuit")
    options = parser.parse_args()
    recipe = lgmd.load_recipe(options.recipe)
    if not isinstance(recipe, lgmd.Recipe):
        parser.error(f"{options.recipe} is no recipe of a fit to curves")
    late = "latency" in recipe.free.names
    circuits = {name: circuit for name, circuit in CIRCUITS.items() if not (late and "lag" in circuit)}
    options.output.mkdir(parents=True, exist_ok=True)
    folders = [options.output / name for name in circuits]
    for folder, circuit in zip(folders, circuits.values(), strict=True):
        if not folder.exists():
            status = run(["fit", options.recipe, "-o", str(folder), "--resume", "--mechanisms", *circuit])
            if status:
                return status
    files = ["--csv", str(options.output / "circuits.csv"), "--figure", str(options.output / "circuits.png")]
    return run(["compare", *map(str, folders), *files, *(["--properties"] if options.properties else [])])


if __name__ == "__main__":
    raise SystemExit(main())
