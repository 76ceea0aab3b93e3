"""`lgmd2jax arena`: robots that drive by the alarms of models."""

import argparse
import math

import jax
from tqdm import tqdm

from lgmd2jax._files.atomic import all_replaced, write_json
from lgmd2jax._handover.named import model_named
from lgmd2jax.arena import Outcome, detectors, run as drive_robots
from lgmd2jax.cli.all_cores import use_all_cores

_DRAWN = 4  # arenas of a figure, as in the paper
_MOST = 10_000  # arenas, which are driven at once
_LONGEST = 3600  # seconds of a trip
_COLUMNS = "detector", "collisions a metre", "ratio to none", "coverage", "ratio to none"


def run(options: argparse.Namespace) -> None:
    """Drive the robots, write what was asked for, and print the table."""
    if not 1 <= options.seeds <= _MOST:
        raise ValueError(f"--seeds is {options.seeds}; give how many arenas, 1 to {_MOST}")
    if not 1 <= options.seconds <= _LONGEST:
        raise ValueError(f"--seconds is {options.seconds:g}; give 1 to {_LONGEST}")
    if options.figure is not None:
        from lgmd2jax._figures.style import check_figure_path

        check_figure_path(options.figure)
    use_all_cores()
    known = detectors(None if options.model is None else model_named(options.model))
    outputs = [path for path in (options.json, options.figure) if path is not None]
    with all_replaced(outputs, [options.model]) as files:
        outcomes, seeds = {}, range(options.seeds)
        for name, detector in tqdm(known.items(), desc="detectors", leave=False):
            layouts, trips = drive_robots(detector, seeds, turn=options.turn, seconds=options.seconds)
            outcomes[name] = Outcome.of(layouts, trips)
            if options.figure and name == "lgmd2":
                from lgmd2jax._figures.arena import trajectories_figure

                first = jax.tree.map(lambda leaf: leaf[:_DRAWN], trips)
                title = f"{options.seconds:g} s by the alarms of {options.model or 'the fitted LGMD2'}"
                trajectories_figure(files[options.figure], layouts[:_DRAWN], first, title)
        if options.json:
            content = {"detectors": {name: _plain(outcome) for name, outcome in outcomes.items()}}
            write_json(files[options.json], content)
    print("\n".join(_table(outcomes)))
    if outputs:
        print("wrote " + ", ".join(str(path) for path in outputs))


def _plain(outcome: Outcome) -> dict[str, dict[str, float]]:
    measures = {"collisions_per_metre": outcome.collisions_per_metre, "coverage": outcome.coverage}
    return {name: estimate._asdict() for name, estimate in measures.items()}


def _table(outcomes: dict[str, Outcome]) -> list[str]:
    none = outcomes["none"]
    rows: list[tuple[str, ...]] = [_COLUMNS]
    for name, outcome in outcomes.items():
        measures = (
            outcome.collisions_per_metre,
            outcome.collisions_by(none),
            outcome.coverage,
            outcome.coverage_by(none),
        )
        rows.append((name, *("-" if math.isnan(measure.value) else str(measure) for measure in measures)))
    first, *others = (max(map(len, column)) for column in zip(*rows, strict=True))
    return ["  ".join([name.ljust(first), *map(str.rjust, measures, others)]) for name, *measures in rows]
