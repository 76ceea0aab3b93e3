"""The sections that recipes of curves and of alarms share: what is free, and which model."""

from collections.abc import Mapping
from typing import Any

from lgmd2jax._eye import Eye
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.parameters import preset, symbols
from lgmd2jax._network.thresholds import Hard, Soft
from lgmd2jax._protocol.arguments import check_keys, section
from lgmd2jax._targets.observation import observation_symbols
from lgmd2jax.fitting._free import RANGES, Free, Linear, Log, Tie

_STRUCTURE = ("n_p", "low_pass", "N_ts")


def free_of(table: Mapping[str, Any]) -> Free:
    """What the section [free] says."""
    return Free(**{name: _choice(name, limits) for name, limits in section(table, "free").items()})


def model_of(table: Mapping[str, Any], eye: Eye) -> LGMD2:
    """The model that preset, [parameters] and [structure] name."""
    parameters = preset(table.get("preset", "lgmd2"), **section(table, "parameters", symbols()))
    thresholds = Soft(table["temperature"]) if "temperature" in table else Hard()
    return LGMD2(parameters, thresholds, eye=eye, **section(table, "structure", _STRUCTURE))


def _choice(name: str, limits: Any) -> Linear | Log | Tie | None:
    """What a line of [free] says: bounds, scale and prior, or a tie."""
    if not isinstance(limits, dict):
        raise ValueError(f"{name} is free in {limits!r}; write a table, such as {{ low = 1, high = 6 }} or {{}}")
    if "tie" in limits:
        check_keys(limits, ("tie", "factor"))
        return Tie(limits["tie"], limits.get("factor", 1.0))
    check_keys(limits, ("low", "high", "scale", "prior"))
    known = symbols() | observation_symbols()
    scale = limits.get("scale", known[name].scale if name in known else "linear")
    if scale not in RANGES:
        raise ValueError(f"{name} has scale {scale!r}; give 'linear' or 'log'")
    return RANGES[scale](limits.get("low"), limits.get("high"), tuple(limits["prior"]) if "prior" in limits else None)
