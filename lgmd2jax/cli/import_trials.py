"""`lgmd2jax import FILE ... -o FOLDER`: from recordings to a protocol that a fit aims at."""

import argparse
from collections import Counter
from collections.abc import Mapping
from typing import Any

from lgmd2jax._eye import Eye
from lgmd2jax._files.folder import check_folder
from lgmd2jax._results.import_folder import MARKER, RECIPE, write_import
from lgmd2jax._trials.quality import RULE, accepted, noisy
from lgmd2jax._trials.trial import told
from lgmd2jax._trials.trials import Trials
from lgmd2jax.cli.options.import_trials import SCREEN
from lgmd2jax.cli.trials_data import trials_of
from lgmd2jax.stimuli import looming

_FASTEST = 10_000.0  # frames a second of a screen


def run(options: argparse.Namespace) -> None:
    """Read the trials, print what was found, and write the folder."""
    if options.output.is_dir() and not options.replace and any(options.output.iterdir()):
        raise ValueError(f"{options.output} is there already; name another folder, or add --replace")
    check_folder(options.output, MARKER)
    given = {name: getattr(options, name) for name in SCREEN if getattr(options, name) is not None}
    assumed = [name for name in SCREEN if name not in given]
    _check_screen(SCREEN | given)
    trials = trials_of(options)
    print(_found(trials))
    kept, excluded = accepted(tuple(trials), options.kernel_ms)
    if not kept:
        raise ValueError("no trial shows a response: " + "; ".join(map(str, excluded)))
    for condition in Trials(tuple(kept)).conditions:
        _check_screen(SCREEN | given | {name: condition[name] for name in SCREEN if name in condition})
    write_import(options.output, trials, Trials(tuple(kept)), SCREEN | given, assumed, options.kernel_ms)
    for item in excluded:
        print(f"left out of the targets: {item}")
    if excluded:
        print(f"rule: {RULE}")
    if assumed:
        told_values = ", ".join(f"--{name.replace('_', '-')} {SCREEN[name]:g}" for name in assumed)
        print(f"assumed: {told_values}; give what your screen showed, or change it in {options.output / MARKER}")
    print(f"wrote {options.output}/; next: lgmd2jax looming {options.output}, lgmd2jax fit {options.output / RECIPE}")


def _check_screen(screen: Mapping[str, float | str]) -> None:
    """Refuse, or warn of, values that a stimulus would refuse or warn of, before they stand in a protocol."""
    for name, value in screen.items():
        if isinstance(value, str):
            raise ValueError(f"{name} is {value!r} in the recordings; write a number there, such as {SCREEN[name]:g}")
    values: dict[str, Any] = dict(screen)
    if values["fps"] > _FASTEST:
        raise ValueError(f"fps is {values['fps']:g}; no screen shows more than {_FASTEST:g} frames per second")
    eye = Eye(rows=3, cols=3, degrees_per_pixel=2.0, fps=values.pop("fps"))
    looming(eye, l_over_v=20.0, start_ms=-4000 / eye.fps, end_ms=0.0, **values)


def _found(trials: Trials) -> str:
    """A table of how many trials each animal has of each condition, and what looks like noise."""
    conditions = [tuple(sorted(condition.items())) for condition in trials.conditions]
    counts = Counter((trial.animal, tuple(sorted(trial.condition.items()))) for trial in trials)
    header = ["animal", *(told(dict(condition)) or "trials" for condition in conditions), "spikes", "span (ms)"]
    rows = [header]
    for animal in trials.animals:
        own = trials.where(animal=animal)
        span = f"{min(trial.start_ms for trial in own):g} to {max(trial.end_ms for trial in own):g}"
        spikes = sum(trial.spikes_ms.size for trial in own)
        rows.append([animal, *(str(counts[animal, condition] or "-") for condition in conditions), str(spikes), span])
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    noise = Counter(trial.animal for trial in noisy(tuple(trials)))
    if noise:
        lines.append(
            f"trials that look like noise: {sum(noise.values())} of {len(trials)} ("
            + ", ".join(f"{animal} {count}" for animal, count in noise.items())
            + ")"
        )
    return "\n".join([*lines, ""])
