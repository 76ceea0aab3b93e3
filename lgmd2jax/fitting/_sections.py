"""The sections, checked, that recipes of curves and of alarms share: what is free, and which model."""

from collections.abc import Mapping
from typing import Any

from lgmd2jax._eye import Eye
from lgmd2jax._network.abstract import AbstractNetwork, parameters_of
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.networks import NETWORKS
from lgmd2jax._network.parameters import preset, symbols
from lgmd2jax._network.thresholds import Hard, Soft, Thresholds
from lgmd2jax._targets.observation import observation_symbols
from lgmd2jax.fitting._bounds import RANGES, Linear, Log
from lgmd2jax.fitting._free import Free, Tie


def free_of(table: Mapping[str, Any]) -> Free:
    """What the section [free] says."""
    return Free(**{name: _choice(name, limits) for name, limits in table["free"].items()})


def network_of(table: Mapping[str, Any], eye: Eye) -> AbstractNetwork:
    """The model that network, preset, [parameters] and [structure] name; without a network an LGMD2."""
    kind: Any = NETWORKS[table.get("network", LGMD2.__name__)]
    if kind is LGMD2:
        return model_of(table, eye)
    parameters = parameters_of(kind)(**table.get("parameters", {}))
    return kind(parameters, _thresholds_of(table), eye=eye, **_structure_of(table))


def model_of(table: Mapping[str, Any], eye: Eye) -> LGMD2:
    """The LGMD2 that preset, [parameters] and [structure] name."""
    parameters = preset(table.get("preset", "lgmd2"), **table.get("parameters", {}))
    return LGMD2(parameters, _thresholds_of(table), eye=eye, **_structure_of(table))


def _thresholds_of(table: Mapping[str, Any]) -> Thresholds:
    return Soft(table["temperature"]) if "temperature" in table else Hard()


def _structure_of(table: Mapping[str, Any]) -> dict[str, Any]:
    """Lists, as TOML has them, are tuples."""
    values = table.get("structure", {})
    return {name: tuple(value) if isinstance(value, list) else value for name, value in values.items()}


def _choice(name: str, limits: Mapping[str, Any]) -> Linear | Log | Tie:
    """What a line of [free] says: bounds, scale and prior, or a tie."""
    if "tie" in limits:
        return Tie(limits["tie"], limits.get("factor", 1.0))
    known = symbols() | observation_symbols()
    scale = limits.get("scale", known[name].scale if name in known else "linear")
    return RANGES[scale](limits.get("low"), limits.get("high"), tuple(limits["prior"]) if "prior" in limits else None)
