"""The forms of recipes: of a fit to curves, of a fit to labelled clips, of a sweep."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, TypeAdapter

from lgmd2jax._channels import RESPONSE
from lgmd2jax._network.abstract import AbstractNetwork, parameters_of
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.networks import NETWORKS
from lgmd2jax._network.parameters import PRESETS, symbols
from lgmd2jax._schemas.keywords import fields_of
from lgmd2jax._schemas.parts import (
    MOST_VALUES,
    Count,
    NotNegative,
    Number,
    Positive,
    Seed,
    Text,
    Truth,
    by_key,
    either,
    names,
    several,
    table,
)
from lgmd2jax._schemas.sections import RENDERING, eye, free, observation, parameters, structure
from lgmd2jax._sweep.responses import SUMMARIES
from lgmd2jax._targets.observation import observation_symbols
from lgmd2jax.stimuli import FAMILIES

DEFAULT_FAMILY = "looming"
AtLeastOne = Annotated[Count, Field(ge=1)]
Temperatures = Annotated[list[Positive], Field(min_length=1)]


_SOLVER = {
    "pixel_points": AtLeastOne,
    "cell_points": AtLeastOne,
    "descend": AtLeastOne,
    "temperatures": Temperatures,
    "max_steps": AtLeastOne,
    "seed": Seed,
}
_CURVE_SOLVER = table("Solver", _SOLVER | {"loss": Literal["squares", "huber", "soft_l1", "cauchy"]})
_ALARM_SOLVER = table("Solver_for_alarms", _SOLVER | {"descend": Count, "generations": Count})
_UNCERTAINTY = table("Uncertainty", {"absolute_errors": Truth, "profile": list[Text], "samples": Count})
_LEFT_OUT = either(
    lambda content: "groups" if isinstance(content, str) else "each", {"each": Truth, "groups": names(["family"])}
)
_VALIDATION = table("Validation", {"leave_one_out": _LEFT_OUT, "looming_law": Truth})
_CHOICE = table("Choice", {"properties": Truth})
_WEIGHTS = table("Weights", {"miss": NotNegative, "false_alarm": NotNegative, "recorded": Positive})


def _fit(network: type[AbstractNetwork]) -> type[BaseModel]:
    name = network.__name__
    known = symbols(parameters_of(network)) | observation_symbols()
    fields = {
        "protocol": (Text, ...),
        "kind": Literal["fit"],
        "by": Literal["animal"],
        "network": names([name]),
        "temperature": Positive,
        "parameters": parameters(network),
        "structure": structure(network),
        "observation": observation(),
        "free": (free(network), ...),
        "solver": _CURVE_SOLVER,
        "uncertainty": _UNCERTAINTY,
        "validation": _VALIDATION,
        "choice": _CHOICE,
        "truth": table(f"{name}_truth", dict.fromkeys(known, Number)),
    }
    return table(f"{name}_fit", fields | ({"preset": names(PRESETS)} if network is LGMD2 else {}))


_ALARMS: dict[str, Any] = {
    "protocol": (Text, ...),
    "kind": (Literal["alarms"], ...),
    "preset": names(PRESETS),
    "parameters": parameters(LGMD2),
    "structure": structure(LGMD2),
    "free": (free(LGMD2), ...),
    "weights": _WEIGHTS,
    "solver": _ALARM_SOLVER,
    "validation": RENDERING,
    "urgency": table("Urgency_within", {"within_ms": (Positive, ...)}),
}


_RANGE = table(
    "Range",
    {
        "from": (Number, ...),
        "to": (Number, ...),
        "count": (Annotated[AtLeastOne, Field(le=MOST_VALUES)], ...),
        "spacing": Literal["linear", "log"],
    },
)


def _axis(kind: Any) -> Any:
    """A value, some, or a range, where the value is a number."""
    if kind is not Number:
        return kind

    def chosen(content: Any) -> str:
        return "range" if isinstance(content, Mapping) else "axis" if isinstance(content, list) else "value"

    some = Annotated[list[Number], Field(min_length=1, max_length=MOST_VALUES)]
    return either(chosen, {"value": Number, "axis": some, "range": _RANGE})


def _sweep(name: str, renderer: Any) -> type[BaseModel]:
    every = [symbol for network in NETWORKS.values() for symbol in symbols(parameters_of(network))]
    fields = {
        "kind": (Literal["sweep"], ...),
        "model": several(Text),
        "eye": (eye(), ...),
        "family": (names([name]), None if name == DEFAULT_FAMILY else ...),
        "stimulus": table(f"{name}_arguments", fields_of(renderer, _axis)),
        "parameters": table("Parameters", dict.fromkeys(every, _axis(Number))),
        "channels": list[names(RESPONSE)],
        "figure": table("Figure", {"value": names(SUMMARIES), "index": Text}),
    }
    return table(f"{name}_sweep", fields)


FIT = by_key("network", {name: _fit(network) for name, network in NETWORKS.items()}, LGMD2.__name__)
ALARMS = table("Alarms", _ALARMS)
SWEEP = by_key("family", {name: _sweep(name, renderer) for name, renderer in FAMILIES.items()}, DEFAULT_FAMILY)
RECIPE = TypeAdapter(by_key("kind", {"fit": FIT, "alarms": ALARMS, "sweep": SWEEP}, "fit"))
