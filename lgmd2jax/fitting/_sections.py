"""The sections that recipes of curves and of alarms share: what is free, and which model."""

from collections.abc import Mapping
from typing import Any

from lgmd2jax._eye import Eye
from lgmd2jax._handover.networks import NETWORKS
from lgmd2jax._network.abstract import AbstractNetwork, parameters_of
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.parameters import preset, symbols
from lgmd2jax._network.structure import structure_fields
from lgmd2jax._network.thresholds import Hard, Soft, Thresholds
from lgmd2jax._protocol.arguments import check_keys, section
from lgmd2jax._targets.observation import observation_symbols
from lgmd2jax._words import nearest
from lgmd2jax.fitting._free import RANGES, Free, Linear, Log, Tie


def free_of(table: Mapping[str, Any]) -> Free:
    """What the section [free] says."""
    return Free(**{name: _choice(name, limits) for name, limits in section(table, "free").items()})


def network_of(table: Mapping[str, Any], eye: Eye) -> AbstractNetwork:
    """The model that network, preset, [parameters] and [structure] name; without a network an LGMD2."""
    name = table.get("network", LGMD2.__name__)
    if name == LGMD2.__name__:
        return model_of(table, eye)
    if name not in NETWORKS:
        raise ValueError(f"network is {name!r}; choose {nearest(str(name), NETWORKS)}")
    if "preset" in table:
        raise ValueError(f"preset is for the LGMD2; write the parameters of a {name} in [parameters]")
    kind: Any = NETWORKS[name]
    values = section(table, "parameters", symbols(parameters_of(kind)))
    return kind(parameters_of(kind)(**values), _thresholds_of(table), eye=eye, **_structure_of(table, kind))


def model_of(table: Mapping[str, Any], eye: Eye) -> LGMD2:
    """The LGMD2 that preset, [parameters] and [structure] name."""
    parameters = preset(table.get("preset", "lgmd2"), **section(table, "parameters", symbols()))
    return LGMD2(parameters, _thresholds_of(table), eye=eye, **_structure_of(table, LGMD2))


def _thresholds_of(table: Mapping[str, Any]) -> Thresholds:
    return Soft(table["temperature"]) if "temperature" in table else Hard()


def _structure_of(table: Mapping[str, Any], kind: type[AbstractNetwork]) -> dict[str, Any]:
    """Lists, as TOML has them, are tuples."""
    values = section(table, "structure", structure_fields(kind))
    return {name: tuple(value) if isinstance(value, list) else value for name, value in values.items()}


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
