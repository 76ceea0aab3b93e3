"""The forms that several documents share: the eye, what is free, parameters and structure of a network."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field

from lgmd2jax._eye import PRESETS, PROJECTIONS
from lgmd2jax._network.abstract import AbstractNetwork, parameters_of
from lgmd2jax._network.parameter_set import Symbol
from lgmd2jax._network.parameters import symbols
from lgmd2jax._network.structure import Structure, structure_fields
from lgmd2jax._schemas.keywords import Wrap, alone
from lgmd2jax._schemas.parts import (
    Count,
    Number,
    Positive,
    Seed,
    Side,
    Text,
    Whole,
    either,
    inside,
    names,
    table,
)
from lgmd2jax._targets.observation import observation_symbols

FRAME_RATE = Annotated[Positive, Field(le=1e6)]


def eye(wrap: Wrap = alone) -> type[BaseModel]:
    """The fields of `Eye`, or a preset and what differs from it."""
    fields = {
        "preset": names(PRESETS),
        "rows": Side,
        "cols": Side,
        "degrees_per_pixel": Annotated[Positive, Field(le=360)],
        "fps": FRAME_RATE,
        "projection": names(PROJECTIONS),
    }
    return table("Eye", {name: wrap(kind) for name, kind in fields.items()})


def parameters(kind: type[AbstractNetwork]) -> type[BaseModel]:
    """Values of parameters by the paper's symbols, each in its domain."""
    return _of_symbols(f"{kind.__name__}_parameters", symbols(parameters_of(kind)))


def observation() -> type[BaseModel]:
    """Values of the parameters of an `Observation`."""
    return _of_symbols("Observation", observation_symbols())


def _of_symbols(name: str, known: Mapping[str, Symbol]) -> type[BaseModel]:
    return table(name, {key: (inside(symbol.domain), described(symbol)) for key, symbol in known.items()})


def described(symbol: Symbol, default: Any = None) -> Any:
    """A field with the meaning of its parameter."""
    unit = "" if symbol.unit == "1" else f", {symbol.unit}"
    return Field(default, description=f"{symbol.meaning}{unit}")


def structure(kind: type[AbstractNetwork]) -> type[BaseModel]:
    """What is compiled into a network."""
    return table(
        f"{kind.__name__}_structure", {name: structure_kind(field) for name, field in structure_fields(kind).items()}
    )


def structure_kind(field: Structure) -> Any:
    """What stands in a document for a structural field."""
    if field.several:
        return list[names(field.choices)]
    if field.least is None:
        return names(field.choices)
    return Annotated[Whole, Field(ge=field.least, le=10_000)]


_PRIOR = Annotated[list[Number], Field(min_length=2, max_length=2, description="mean, standard deviation")]
_BOUNDS = table("Bounds", {"low": Number, "high": Number, "scale": Literal["linear", "log"], "prior": _PRIOR})
_TIE = table("Tie", {"tie": (Text, ...), "factor": Number})


def free(kind: type[AbstractNetwork]) -> type[BaseModel]:
    """What a fit may change: for each parameter where it may lie, or which one it follows."""
    choice = either(_is_tie, {"bounds": _BOUNDS, "tie": _TIE})
    known = symbols(parameters_of(kind)) | observation_symbols()
    return table(f"{kind.__name__}_free", {name: (choice, described(symbol)) for name, symbol in known.items()})


def _is_tie(content: Any) -> str:
    return "tie" if isinstance(content, Mapping) and "tie" in content else "bounds"


_RENDERING = {
    "count": (Annotated[Count, Field(ge=1)], ...),
    "seed": Seed,
    "world": names(["encounters", "films"]),
    "duration_ms": Annotated[Positive, Field(le=1e6)],
    "alarm_below_ms": Positive,
    "silent_above_ms": Positive,
}
RENDERING = table("Rendering", _RENDERING)
