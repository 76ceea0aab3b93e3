"""The form of the hand-over file model.json, versions 1 and 2. `hard.py` checks the same in plain Python."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, TypeAdapter

from lgmd2jax import hard
from lgmd2jax._eye import PROJECTIONS
from lgmd2jax._network.abstract import AbstractNetwork, parameters_of
from lgmd2jax._network.lgmd2 import LGMD2, MECHANISMS
from lgmd2jax._network.networks import NETWORKS
from lgmd2jax._network.parameter_set import Symbol
from lgmd2jax._network.parameters import symbols
from lgmd2jax._network.structure import structure_fields
from lgmd2jax._schemas.parts import (
    NotNegative,
    Number,
    OpenTable,
    Positive,
    Text,
    Truth,
    Whole,
    either,
    inside,
    is_null,
    names,
    table,
)
from lgmd2jax._schemas.sections import described, structure_kind

_SIDE = Annotated[Whole, Field(ge=3)]


def _parameters(name: str, known: Mapping[str, Symbol]) -> type[BaseModel]:
    return table(name, {key: (inside(symbol.domain), described(symbol, ...)) for key, symbol in known.items()})


def _eye() -> Any:
    degrees = either(is_null, {"null": type(None), "value": Positive})
    eye = {
        "rows": (_SIDE, ...),
        "cols": (_SIDE, ...),
        "degrees_per_pixel": (degrees, ...),
        "fps": (Positive, ...),
        "projection": (names(PROJECTIONS), ...),
    }
    return either(is_null, {"null": type(None), "value": table("Eye", eye)})


def _test_vector() -> type[BaseModel]:
    grey = Annotated[Whole, Field(ge=0, le=255)]
    row = Annotated[list[grey], Field(min_length=3)]
    frame = Annotated[list[row], Field(min_length=3)]
    response = {
        "mp": (list[Number], Field(description="MP, grey levels")),
        "ffi": (list[Number], Field(description="delayed inhibition, grey levels, or a share of the field")),
        "smp": (list[Number], Field(description="U")),
        "smp_adapted": (list[Number], Field(description="U'")),
        "spikes": (list[Whole], ...),
        "collision": (list[Truth], Field(description="the alarm")),
    }
    vector = {
        "fps": (Positive, Field(description="frames per second, those of the eye")),
        "tolerance": (
            Annotated[Positive, Field(le=1e-3)],
            Field(description="share of a channel's largest value by which it may be off; not of spikes and alarm"),
        ),
        "frames": (Annotated[list[frame], Field(min_length=3)], Field(description="grey levels of (time, row, col)")),
        "response": (table("Response", response), Field(description="a value for each frame, from rest")),
    }
    return table("Test_vector", vector)


def _calibration() -> type[BaseModel]:
    """What is measured of a model, by name; of these the urgency is known here."""
    kinds = {name: Positive if name.endswith("_ms") else Number for name in hard.URGENCY}
    column = list[Annotated[NotNegative, Field(le=1)]]
    columns = dict.fromkeys(hard.CALIBRATION, column)
    urgency = table("Urgency", {name: (kind, ...) for name, kind in kinds.items()} | columns)
    return table("Calibration", {"urgency": urgency}, base=OpenTable)


_COMMON: dict[str, Any] = {
    "format": (Literal["lgmd2jax-model"], ...),
    "version": (Literal[2], ...),
    "eye": (_eye(), ...),
    "provenance": (dict[Text, Any], ...),
    "test_vector": (_test_vector(), ...),
}


def _of(network: type[AbstractNetwork]) -> dict[str, Any]:
    """What the file says of a network that the library has; the values of mechanisms stand in tables of their own."""
    name, known = network.__name__, symbols(parameters_of(network))
    own = {key: symbol for key, symbol in known.items() if symbol.mechanism is None}
    static = {key: field for key, field in structure_fields(network).items() if key != "mechanisms"}
    return _COMMON | {
        "parameters": (_parameters(f"{name}_parameters", own), ...),
        "structure": (table(f"{name}_structure", {key: (structure_kind(f), ...) for key, f in static.items()}), ...),
    }


def _mechanisms() -> type[BaseModel]:
    tables = {}
    for mechanism in MECHANISMS:
        own = {key: symbol for key, symbol in symbols().items() if symbol.mechanism == mechanism}
        tables[mechanism] = _parameters(f"Mechanism_{mechanism}", own)
    return table("LGMD2_mechanisms", tables)


def _forms() -> dict[str, type[BaseModel]]:
    own = _COMMON | {
        "network": (Annotated[Text, Field(json_schema_extra={"not": {"enum": list(NETWORKS)}})], ...),
        "parameters": (dict[Text, Number], ...),
        "mechanisms": dict[Text, dict[Text, Number]],
        "structure": (dict[Text, Any], ...),
        "calibration": _calibration(),
    }
    forms = {
        "version 1": table("Version_1", _of(LGMD2) | {"version": (Literal[1], ...)}),
        "own": table("Network_of_your_own", own),
    }
    for name, network in NETWORKS.items():
        later = {
            "network": (names([name]), ...),
            "mechanisms": _mechanisms() if network is LGMD2 else Annotated[dict[Text, Any], Field(max_length=0)],
            "calibration": _calibration(),
        }
        forms[name] = table(name, _of(network) | later)
    return forms


def _form(content: Any) -> str | None:
    if not isinstance(content, Mapping):
        return "own"
    version, network = content.get("version"), content.get("network")
    if type(version) is not int or version not in (1, 2):
        return None
    return "version 1" if version == 1 else network if isinstance(network, str) and network in NETWORKS else "own"


MODEL_FILE = TypeAdapter(either(_form, _forms(), path=("version",), cure="this program reads 1 and 2; update it"))
