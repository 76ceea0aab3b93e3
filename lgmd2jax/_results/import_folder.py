"""A folder of imported recordings: the trials, a protocol with them as targets, a recipe of a fit, and a figure."""

import csv
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from lgmd2jax._figures.trials import trials_figure
from lgmd2jax._files.folder import replaced_folder
from lgmd2jax._trials.trial import Condition, Trial, told
from lgmd2jax._trials.trials import Trials

MARKER, RECIPE = "protocol.toml", "fit.toml"
_TRIALS, _SPIKES, _TARGETS, _FIGURE = "trials.csv", "spikes.csv", "targets", "trials.png"
_SHOWN = ("contrast", "background")  # conditions that a looming stimulus takes, besides l_over_v
_EYE = "rows = 40\ncols = 56\ndegrees_per_pixel = 2.0"

# Of a recording what a fit is shown: so many l/|v| and ms before collision, and ms after. The rest is silence.
_LEAD_SPEEDS, _LEAD_MS, _LAST_MS = 20.0, 900.0, 500.0

_FIT = """\
# A fit of the LGMD's circuit to the recordings: {fit}
protocol = "protocol.toml"
kind = "fit"
{by}preset = "balanced"    # ON and OFF alike, as the DCMD's input

[structure]
mechanisms = ["shunt"] # for the exponent of the excitation: the recorded rate begins slowly, as a power of the drive

[parameters]           # those that dark looms do not tell apart are held
tau1 = 15.0            # ms
T_s = 3.0              # grey levels
T_sfa = 2e-3
sigma1 = 0.316
tau2 = 800.0           # ms
T_ffi = 60.0           # grey levels

[observation]          # rate(t) = baseline + gain 2 (U'(t - latency) - .5), then smoothed as the recording is
baseline = 5.0         # spikes/s
gain = 90.0            # spikes/s
latency = 40.0         # ms, of screen and neuron
smoothing = {kernel_ms:g}       # ms

[free]
k = {{ low = 0.05, high = 3 }}
gamma = {{}}
tau3 = {{ low = 50, high = 1500 }}
baseline = {{ low = 0, high = 20 }}
gain = {{ low = 10, high = 600 }}
latency = {{ low = 0, high = 120 }}

[solver]
pixel_points = 2
cell_points = 1024
descend = 2
temperatures = [0.5, 0.2, 0.05]
seed = 0

[uncertainty]
absolute_errors = false
"""


def write_import(
    folder: Path,
    trials: Trials,
    accepted: Trials,
    screen: Mapping[str, float],
    assumed: Sequence[str],
    kernel_ms: float,
) -> None:
    """Write the folder, whole or not at all.

    **Arguments:**

    - `trials`: all, which are kept and drawn. `accepted`: those that a fit is to aim at.
    - `screen`: `fps`, `stop_angle`, `contrast`, `background`; what a condition tells goes before.
    - `assumed`: those of them that nobody gave.

    **Raises:** `ValueError` as `replaced_folder`.
    """
    own = (_TRIALS, _SPIKES, _TARGETS, _FIGURE, MARKER, RECIPE)
    with replaced_folder(folder, MARKER, own) as temporary:
        _write_trials(temporary, trials)
        (temporary / _TARGETS).mkdir()
        conditions = []
        for condition in accepted.conditions:
            shown = [trial for trial in accepted if trial.condition == condition]
            target = f"{_TARGETS}/{_file_name(condition)}.csv"
            _write_target(temporary / target, shown)
            conditions.append(_condition(condition, shown, target, screen, assumed, kernel_ms))
        eye = f"[eye]\n{_EYE}\nfps = {screen['fps']:g}{_remark('fps', assumed)}\n"
        text = "\n".join(
            ["# The recorded looms: what was shown, and the spikes that a model is fitted to.", eye, *conditions]
        )
        (temporary / MARKER).write_text(text, encoding="utf-8")
        by = (
            'by = "animal"          # without this line one fit to the mean of all animals\n'
            if len(accepted.animals) > 1
            else ""
        )
        text = _FIT.format(fit=f"lgmd2jax fit {folder / RECIPE}", by=by, kernel_ms=kernel_ms)
        (temporary / RECIPE).write_text(text, encoding="utf-8")
        trials_figure(temporary / _FIGURE, trials, kernel_ms)


def _write_trials(folder: Path, trials: Trials) -> None:
    """The trials as two tables, which `load_trials` reads back."""
    names = [name for name in trials.names if name != "l_over_v"]
    header = ["animal", "session", "trial", "l_over_v_ms", *names, "collision_ms", "start_ms", "end_ms"]
    spikes, rows = [], []
    for trial, label in zip(trials, _labels(trials), strict=True):
        speed = trial.condition.get("l_over_v", "")
        shown = [trial.condition.get(name, "") for name in names]
        rows.append([trial.animal, trial.session, label, speed, *shown, 0, trial.start_ms, trial.end_ms])
        spikes += [[trial.animal, trial.session, label, f"{time:.6f}"] for time in trial.spikes_ms]
    keep = [place for place, name in enumerate(header) if name != "session" or any(row[1] for row in rows)]
    _write_csv(folder / _TRIALS, [[row[place] for place in keep] for row in [header, *rows]])
    keep = [place for place in range(4) if place != 1 or any(row[1] for row in rows)]
    header = ["animal", "session", "trial", "spike_ms"]
    _write_csv(folder / _SPIKES, [[row[place] for place in keep] for row in [header, *spikes]])


def _labels(trials: Iterable[Trial]) -> list[str]:
    """The names of the trials, numbered anew where they do not tell the trials of a session apart."""
    trials = list(trials)
    keys = [(trial.animal, trial.session, trial.name) for trial in trials]
    if len(set(keys)) == len(keys):
        return [trial.name for trial in trials]
    return [str(number) for number in range(1, len(trials) + 1)]


def _write_target(path: Path, trials: Sequence[Trial]) -> None:
    """A row a spike; a trial without spikes has a row without a time."""
    rows: list[list[Any]] = [["animal", "trial", "time_ms"]]
    for number, trial in enumerate(trials, start=1):
        rows += [[trial.animal, number, f"{time:.6f}"] for time in trial.spikes_ms]
        if not trial.spikes_ms.size:
            rows.append([trial.animal, number, ""])
    _write_csv(path, rows)


def _condition(
    condition: Condition,
    trials: Sequence[Trial],
    target: str,
    screen: Mapping[str, float],
    assumed: Sequence[str],
    kernel_ms: float,
) -> str:
    lines = [f"[[condition]]\nname = {json.dumps(_name(condition), ensure_ascii=False)}", 'family = "looming"']
    lines.append(f"l_over_v = {condition['l_over_v']:g}")
    for name in ("stop_angle", *_SHOWN):
        told_here = isinstance(condition.get(name), float)
        value = condition[name] if told_here else screen[name]
        lines.append(f"{name} = {value:g}{'' if told_here else _remark(name, assumed)}")
    earliest = -_LEAD_SPEEDS * float(condition["l_over_v"]) - _LEAD_MS
    lines.append(f"start_ms = {max(earliest, *(trial.start_ms for trial in trials)):g}")
    lines.append(f"end_ms = {min(_LAST_MS, *(trial.end_ms for trial in trials)):g}")
    lines.append(f'[[condition.target]]\nspikes = "{target}"\nkernel_ms = {kernel_ms:g}\n')
    return "\n".join(lines)


def _name(condition: Condition) -> str:
    others = {name: value for name, value in condition.items() if name != "l_over_v"}
    return f"approach {condition['l_over_v']:g} ms" + (f", {told(others)}" if others else "")


def _file_name(condition: Condition) -> str:
    name = _name(condition)
    return "".join(sign if sign.isalnum() or sign in ".-" else "_" for sign in name)


def _remark(name: str, assumed: Sequence[str]) -> str:
    return "    # assumed" if name in assumed else ""


def _write_csv(path: Path, rows: Sequence[Sequence[Any]]) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)
