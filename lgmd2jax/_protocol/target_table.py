"""A target as a table of a protocol: where its curve comes from, and how much it counts."""

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import equinox as eqx
import jax

from lgmd2jax._handover.named import model_named, with_parameters
from lgmd2jax._network.thresholds import Soft
from lgmd2jax._protocol.arguments import arguments, located
from lgmd2jax._schemas.protocol import LAWS
from lgmd2jax._targets.csv_files import read_spike_trains, read_target
from lgmd2jax._targets.model_target import ModelTarget
from lgmd2jax._targets.observation import Observation
from lgmd2jax._targets.target import AnyTarget
from lgmd2jax._targets.weighted import Weighted

Table = Mapping[str, Any]

_WEIGHTING = [field.name for field in dataclasses.fields(Weighted) if field.name != "target"]


def target(table: Table, folder: Path) -> AnyTarget:
    """The target that a table, whose form is checked, describes; its files, which lie below `folder`, are read.

    ```toml
    [[condition.target]]                  # a recorded curve
    file = "targets/psth.csv"             # with a column named like a time, such as time_ms
    channel = "rate"
    column = "rate_lv{l_over_v}_mean"     # or a list of columns, a trial each
    sem = "rate_lv{l_over_v}_sem"         # where there are standard errors
    interpolate = true                    # onto the frames; without it the times must be theirs
    where = { animal = "A" }              # only these rows; and all else that read_target takes

    [[condition.target]]                  # recorded spike times, in columns animal, trial and time_ms
    spikes = "targets/spikes.csv"
    kernel_ms = 20
    where = { l_over_v = "{l_over_v}" }   # only these rows; and all else that read_spike_trains takes

    [[condition.target]]                  # a law, with the arguments of LoomingLaw, Rest, Onset or Band
    law = "looming"                       # or "rest", "onset", "band"
    peak = 0.4

    [[condition.target]]                  # a band: what a sentence tells that gives no curve
    law = "band"
    quote = "briefly excited"
    segments_ms = [[0, 150], [300, 1000]] # between them nothing counts
    low = [0.55, 0.5]
    high = [0.8, 0.55]
    error = 0.05                          # of a response outside, by its distance

    [[condition.target]]                  # what another model answers
    model = "preset:balanced"             # or a hand-over file, or the name of a shipped fit
    parameters = { tau1 = 20 }
    temperature = 1.0                     # soft thresholds; without it hard ones
    channel = "rate"
    observation = { gain = 90 }
    noise = 2.0                           # spikes/s
    seed = 0
    ```

    Each also takes `error`, `weight`, `from_ms`, `until_ms` and `correlation_ms`: see `Weighted`.

    **Raises:** `ValueError` for what the values cannot be, and for files that cannot be read.
    """
    source = next(name for name in _SOURCES if name in table)
    own = {key: value for key, value in table.items() if key not in (source, *_WEIGHTING)}
    weighting = {key: value for key, value in table.items() if key in _WEIGHTING}
    try:
        result = _SOURCES[source](table[source], own, folder)
    except OSError as error:
        raise ValueError(f"{source} = {table[source]!r}: cannot be read: {error.strerror or error}") from error
    return Weighted(result, **arguments(Weighted, weighting, folder)) if weighting else result


def _recorded(name: str, table: Table, folder: Path) -> AnyTarget:
    return read_target(folder / name, **arguments(read_target, table, folder))


def _spikes(name: str, table: Table, folder: Path) -> AnyTarget:
    settings = {key: value for key, value in table.items() if key != "channel"}
    return read_spike_trains(folder / name, **arguments(read_spike_trains, settings, folder))


def _law(name: str, table: Table, folder: Path) -> AnyTarget:
    return LAWS[name](**arguments(LAWS[name], table, folder))


def _model(name: str, table: Table, folder: Path) -> AnyTarget:
    settings = [f"{key}={value}" for key, value in table.get("parameters", {}).items()]
    model = with_parameters(model_named(located(name, folder)), settings)
    if "temperature" in table:
        model = eqx.tree_at(lambda model: model.thresholds, model, Soft(table["temperature"]))
    plain = {key: value for key, value in table.items() if key in ("channel", "noise")}
    return ModelTarget(
        model=model,
        observation=Observation(**table["observation"]) if "observation" in table else None,
        key=jax.random.key(table.get("seed", 0)),
        **arguments(ModelTarget, plain, folder),
    )


_SOURCES: dict[str, Callable[[str, Table, Path], AnyTarget]] = {
    "file": _recorded,
    "spikes": _spikes,
    "law": _law,
    "model": _model,
}
