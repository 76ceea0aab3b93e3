"""Trials whose law is known: Poisson trains with peaks on the line alpha 4.4, delta 18.7 ms, and files of them."""

import csv
import datetime
import pathlib
from typing import Any, NamedTuple

import h5py
import neo
import neo.io
import numpy as np
import openpyxl
import pynwb
import quantities as pq
import scipy.io

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
    trials, spikes = _two_tables(made)
    folder.mkdir(exist_ok=True)
    _write(folder / "trials.csv", trials)
    _write(folder / "spikes.csv", spikes)


def _two_tables(made: list[Made]) -> tuple[list[list[str]], list[list[str]]]:
    trials = [["animal", "trial", "l_over_v_ms", "impact_s", "start_s", "end_s"]]
    spikes = [["animal", "trial", "spike_s"]]
    for trial, impact in zip(made, _impacts(made), strict=True):
        span = [f"{impact + edge / 1000:.6f}" for edge in WINDOW]
        trials.append([trial.animal, trial.trial, f"{trial.l_over_v:g}", f"{impact:.6f}", *span])
        spikes += [[trial.animal, trial.trial, f"{impact + t / 1000:.6f}"] for t in trial.spikes]
    return trials, spikes


def write_workbook(path: pathlib.Path, made: list[Made]) -> None:
    """Two sheets as the two tables."""
    trials, spikes = _two_tables(made)
    workbook = openpyxl.Workbook()
    workbook.remove(workbook.worksheets[0])
    for title, (header, *rows) in (("trials", trials), ("spikes", spikes)):
        sheet = workbook.create_sheet(title)
        sheet.append(header)
        for row in rows:
            sheet.append([_cell(cell) for cell in row])
    workbook.save(path)


def write_matlab(path: pathlib.Path, made: list[Made]) -> None:
    """A struct array of trials."""
    fields = [("animal", object), ("trial", object), ("l_over_v_ms", object), ("spikes_s", object)]
    array = np.empty((1, len(made)), dtype=fields)
    for place, trial in enumerate(made):
        array[0, place] = (trial.animal, float(trial.trial), trial.l_over_v, np.array(trial.spikes) / 1000)
    scipy.io.savemat(path, {"recordings": array})


def write_matlab_73(path: pathlib.Path, made: list[Made]) -> None:
    """A cell array of spike times beside vectors, as version 7.3 keeps them."""
    file: Any
    with h5py.File(path, "w", userblock_size=512) as file:
        parts = file.create_group("#refs#")

        def cells(name, values, kind):
            references = []
            for place, value in enumerate(values):
                part = parts.create_dataset(f"{name}{place}", data=value)
                part.attrs["MATLAB_class"] = np.bytes_(kind)
                if not np.size(value):
                    part.attrs["MATLAB_empty"] = np.uint8(1)
                references.append(part.ref)
            cell = file.create_dataset(name, data=np.array(references, dtype=h5py.ref_dtype).reshape(-1, 1))
            cell.attrs["MATLAB_class"] = np.bytes_("cell")

        cells("animal", [np.array([[ord(letter)] for letter in trial.animal], np.uint16) for trial in made], "char")
        cells("spikes_s", [np.array(trial.spikes).reshape(-1, 1) / 1000 for trial in made], "double")
        for name, values in (
            ("trial", [float(trial.trial) for trial in made]),
            ("l_over_v_ms", [trial.l_over_v for trial in made]),
        ):
            file.create_dataset(name, data=np.array(values).reshape(-1, 1)).attrs["MATLAB_class"] = np.bytes_("double")
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64")


def write_nwb(path: pathlib.Path, made: list[Made], event: str = "collision_time", units: tuple[str, ...] = ()) -> None:
    """One animal: a unit on the clock of the session, and a table of trials.

    **Arguments:** `units`: names of several, the first of which has the spikes.
    """
    start = datetime.datetime(2020, 1, 1, tzinfo=datetime.UTC)
    library: Any = pynwb
    file = library.NWBFile("looms", "synthetic", start)
    file.subject = library.file.Subject(subject_id=made[0].animal, species="Locusta migratoria")
    for name in ("trial", "l_over_v_ms", event):
        file.add_trial_column(name, name)
    spikes = []
    for trial, impact in zip(made, _impacts(made), strict=True):
        first, last = (impact + edge / 1000 for edge in WINDOW)
        file.add_trial(first, last, trial=int(trial.trial), l_over_v_ms=trial.l_over_v, **{event: impact})
        spikes += [impact + t / 1000 for t in trial.spikes]
    if units:
        file.add_unit_column("unit_name", "name")
    for number, name in enumerate(units or ("",)):
        named = {"unit_name": name} if units else {}
        file.add_unit(spike_times=np.array([1.0] if number else spikes), **named)
    with library.NWBHDF5IO(path, "w") as writer:
        writer.write(file)


def neo_block(made: list[Made]) -> neo.Block:
    """A segment a trial, on a clock that starts with it."""
    block = neo.Block()
    for trial in made:
        segment = neo.Segment(animal=trial.animal, trial=trial.trial, l_over_v=trial.l_over_v)
        times = (np.array(trial.spikes) - WINDOW[0]) / 1000
        stop = (WINDOW[1] - WINDOW[0]) / 1000
        segment.spiketrains.append(neo.SpikeTrain(times * pq.s, t_stop=stop * pq.s, name="DCMD"))
        segment.events.append(neo.Event(np.array([-WINDOW[0]]) * pq.ms, labels=np.array(["hit"]), name="collision"))
        block.segments.append(segment)
    return block


def write_neo(path: pathlib.Path, made: list[Made]) -> None:
    """The block as a NIX file."""
    writer = neo.io.NixIO(str(path), mode="ow")
    writer.write_block(neo_block(made))
    writer.close()


def write_spike2(path: pathlib.Path, made: list[Made]) -> None:
    """One animal: an export of a waveform, spikes and marks with a text, in seconds; trials count from 1.

    Laid out as the comments of public readers show it, FieldTrip's among them.
    """
    lines = ['"INFORMATION"', '"' + made[0].animal + '.smr"', '""', '""', "", '"SUMMARY"']
    lines += ['"1"\t"Waveform"\t"nerve"\t" volt"\t256\t255.754476\t1\t0', '"2"\t"Evt+"\t"DCMD"\t150\t""']
    lines += ['"31"\t"TextMark"\t"collision"', "", '"CHANNEL"\t"1"', '"Waveform"', '"No comment"', '"nerve"', ""]
    lines += ['" volt"\t256', '"START"\t0.00000\t0.00391', "-0.00565", "0.01022", '"GAP"\t7.50000\t0.00391', "-0.01175"]
    lines += ["", '"CHANNEL"\t"2"', '"Evt+"', '"No comment"', '"DCMD"', ""]
    marks = ["", '"CHANNEL"\t"31"', '"TextMark"', '"No comment"', '"collision"', ""]
    for trial, impact in zip(made, _impacts(made), strict=True):
        lines += [f"{impact + t / 1000:.6f}" for t in trial.spikes]
        marks.append(f'{impact:.6f}\t"A???"\t65\t0\t0\t0\t"lv{trial.l_over_v:g}"')
    path.write_text("\n".join([*lines, *marks]) + "\n", encoding="utf-8", newline="\r\n")


def _impacts(made: list[Made]) -> list[float]:
    return [45.5 + 10 * number for number in range(len(made))]


def _cell(text: str) -> str | float:
    try:
        return float(text)
    except ValueError:
        return text


def _side_by_side(made: list[Made], factor: float) -> list[list[str]]:
    longest = max(len(trial.spikes) for trial in made)
    return [[f"{factor * t.spikes[i]:.6f}" if i < len(t.spikes) else "" for t in made] for i in range(longest)]


def _write(path: pathlib.Path, rows: list[list[str]]) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(rows)
