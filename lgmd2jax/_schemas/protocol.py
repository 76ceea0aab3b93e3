"""The form of a protocol."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, TypeAdapter

from lgmd2jax._channels import TARGETS
from lgmd2jax._network.abstract import parameters_of
from lgmd2jax._network.networks import NETWORKS
from lgmd2jax._network.parameters import symbols
from lgmd2jax._schemas.keywords import fields_of
from lgmd2jax._schemas.parts import (
    NotNegative,
    Number,
    OpenEnd,
    Positive,
    Seed,
    Text,
    by_key,
    either,
    is_list,
    names,
    several,
    table,
)
from lgmd2jax._schemas.sections import eye, observation
from lgmd2jax._targets.band import Band
from lgmd2jax._targets.csv_files import read_spike_trains, read_target
from lgmd2jax._targets.looming_law import LoomingLaw
from lgmd2jax._targets.rest import Onset, Rest
from lgmd2jax.stimuli import FAMILIES, camera

LAWS = {"looming": LoomingLaw, "rest": Rest, "onset": Onset, "band": Band}


_WEIGHTING = {
    "error": Positive,
    "weight": NotNegative,
    "from_ms": Number,
    "until_ms": Number,
    "correlation_ms": Positive,
}


def _law(name: str, law: type) -> type[BaseModel]:
    fields = {"law": (names([name]), ...)} | fields_of(law) | _WEIGHTING
    if law is Band:
        edge = either(is_list, {"value": OpenEnd, "list": list[OpenEnd]})
        fields |= {"low": (edge, ...), "high": (edge, ...)}
    return table(f"{law.__name__}_target", fields)


def _sources() -> dict[str, Any]:
    every = {name: Number for kind in NETWORKS.values() for name in symbols(parameters_of(kind))}
    curve = {"file": (Text, ...)} | fields_of(read_target)
    spikes = {"spikes": (Text, ...), "channel": Literal["rate"]} | fields_of(read_spike_trains)
    answer = {
        "model": (Text, ...),
        "parameters": table("Parameters", every),
        "temperature": Positive,
        "channel": names(TARGETS),
        "observation": observation(),
        "noise": NotNegative,
        "seed": Seed,
    }
    return {
        "file": table("Recorded_curve", curve | _WEIGHTING),
        "spikes": table("Recorded_spikes", spikes | _WEIGHTING),
        "law": by_key("law", {name: _law(name, law) for name, law in LAWS.items()}),
        "model": table("Answer_of_a_model", answer | _WEIGHTING),
    }


def _target() -> Any:
    sources = _sources()

    def chosen(content: Any) -> str | None:
        given = [name for name in sources if name in content] if isinstance(content, Mapping) else ["file"]
        return given[0] if len(given) == 1 else None

    return either(chosen, sources, cure=f"give one of {', '.join(sources)} as its source")


TARGET = _target()


def _conditions() -> dict[str, type[BaseModel]]:
    """The form of a condition of each family, and of one in which the family is an axis."""
    common = {
        "name": (several(Text), ...),
        "eye": eye(several),
        "camera": several(table("Camera", {"seed": several(Seed)} | fields_of(camera, several, several))),
        "target": list[TARGET],
    }
    forms: dict[str, type[BaseModel]] = {}
    every: dict[str, Any] = {}
    for name, renderer in FAMILIES.items():
        own = fields_of(renderer, several, several)
        forms[name] = table(f"{name}_condition", {"family": (names([name]), ...)} | common | own)
        every |= own
    # Which keys all its families take is told when the grid is expanded.
    forms["several"] = table(
        "condition", {"family": (Annotated[list[names(FAMILIES)], Field(min_length=1)], ...)} | common | every
    )
    return forms


def _condition() -> Any:
    forms = _conditions()

    def chosen(content: Any) -> str | None:
        family = content.get("family") if isinstance(content, Mapping) else []
        if isinstance(family, list):
            return "several"
        return family if isinstance(family, str) and family in FAMILIES else None

    return either(chosen, forms, path=("family",), known=list(FAMILIES))


_CONDITIONS = Annotated[list[_condition()], Field(min_length=1)]
PROTOCOL = TypeAdapter(
    table("Protocol", {"eye": (eye(several), ...), "condition": (_CONDITIONS, ...), "target": list[TARGET]})
)
