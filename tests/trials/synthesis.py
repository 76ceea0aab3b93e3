"""Trials whose law is known: Poisson trains with peaks on the line alpha 4.4, delta 18.7 ms, and files of them."""

import csv
import pathlib
from typing import NamedTuple

import numpy as np

ALPHA, DELTA_MS = 4.4, 18.7
WINDOW = (-700.0, 400.0)
SPEEDS = (10.0, 20.0, 40.0, 80.0)
NOISY = "D"  # an animal whose events are noise
UNSEEN = "3"  # a trial of animal A at 10 ms without a spike
_BASE, _PEAK, _WIDTH_MS = 4.0, 150.0, 35.0  # spikes/s, s.d. of the bump


class Made(NamedTuple):
    """A trial: times in ms from collision, to a microsecond."""

    animal: str
    l_over_v: float
    trial: str
    spikes: list[float]


def recordings(animals: str = "ABCD", trials: int = 8, seed: int = 0) -> list[Made]:
    """All trials; the numbers of trials go on over l/|v|."""
    rng = np.random.default_rng(seed)
    grid = np.arange(WINDOW[0] + 0.5, WINDOW[1], 1.0)
    made = []
    for animal in animals:
        for number, (speed, _) in enumerate([(speed, rep) for speed in SPEEDS for rep in range(trials)]):
            bump = np.exp(-0.5 * ((grid + ALPHA * speed - DELTA_MS) / _WIDTH_MS) ** 2)
            rate = np.full(grid.shape, 90.0) if animal == NOISY else _BASE + _PEAK * bump
            spikes = np.repeat(grid, rng.poisson(rate / 1000))
            spikes = np.unique(np.round(spikes + rng.uniform(-0.5, 0.5, spikes.size), 3))
            if (animal, str(number)) == ("A", UNSEEN):
                spikes = spikes[:0]
            made.append(Made(animal, speed, str(number), spikes.tolist()))
    return made


def write_tidy(path: pathlib.Path, made: list[Made], separator: str = ",", point: str = ".", bom: bool = False) -> None:
    """A row a spike, in ms; a trial without spikes has a row without a time."""
    lines = [("animal", "trial", "l_over_v_ms", "spike_ms")]
    for trial in made:
        lines += [(trial.animal, trial.trial, f"{trial.l_over_v:g}", f"{t:.3f}") for t in trial.spikes or []]
        if not trial.spikes:
            lines.append((trial.animal, trial.trial, f"{trial.l_over_v:g}", ""))
    text = "\n".join(separator.join(cell.replace(".", point) for cell in line) for line in lines)
    path.write_text(text + "\n", encoding="utf-8-sig" if bom else "utf-8")


def write_named_columns(path: pathlib.Path, made: list[Made]) -> None:
    """A column a trial, in seconds, whose name tells animal, l/|v| and number."""
    header = [f"{trial.animal}_lv{trial.l_over_v:g}_trial{trial.trial} (s)" for trial in made]
    _write(path, [header, *_side_by_side(made, 1e-3)])


def write_labelled_columns(path: pathlib.Path, made: list[Made]) -> None:
    """A column a trial, in seconds, below rows of labels."""
    rows = [
        ["animal", *(trial.animal for trial in made)],
        ["l_over_v_ms", *(f"{trial.l_over_v:g}" for trial in made)],
        ["trial", *(trial.trial for trial in made)],
    ]
    times = [["" if number else "spike_s", *row] for number, row in enumerate(_side_by_side(made, 1e-3))]
    _write(path, [*rows, *times])


def write_two_tables(folder: pathlib.Path, made: list[Made]) -> None:
    """`trials.csv` and `spikes.csv`, in seconds on the clock of a session, with the span of each trial."""
    trials, spikes = (
        [["animal", "trial", "l_over_v_ms", "impact_s", "start_s", "end_s"]],
        [["animal", "trial", "spike_s"]],
    )
    for number, trial in enumerate(made):
        impact = 45.5 + 10 * number
        span = [f"{impact + edge / 1000:.6f}" for edge in WINDOW]
        trials.append([trial.animal, trial.trial, f"{trial.l_over_v:g}", f"{impact:.6f}", *span])
        spikes += [[trial.animal, trial.trial, f"{impact + t / 1000:.6f}"] for t in trial.spikes]
    folder.mkdir(exist_ok=True)
    _write(folder / "trials.csv", trials)
    _write(folder / "spikes.csv", spikes)


def _side_by_side(made: list[Made], factor: float) -> list[list[str]]:
    longest = max(len(trial.spikes) for trial in made)
    return [[f"{factor * t.spikes[i]:.6f}" if i < len(t.spikes) else "" for t in made] for i in range(longest)]


def _write(path: pathlib.Path, rows: list[list[str]]) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(rows)
