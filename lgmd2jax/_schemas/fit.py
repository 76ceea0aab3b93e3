"""The forms of a fit's results: fit.json, as far as a fit is read from it, and the rows of curves.csv."""

import dataclasses
from typing import Annotated, Any, Literal

from pydantic import Field, TypeAdapter

from lgmd2jax._channels import TARGETS
from lgmd2jax._network.thresholds import Widths
from lgmd2jax._schemas.parts import (
    NotNegative,
    Number,
    OpenEnd,
    OpenTable,
    Positive,
    Text,
    Truth,
    Whole,
    by_key,
    either,
    is_null,
    names,
    table,
)
from lgmd2jax._targets.observation import observation_symbols

# JSON has no word for what is not finite.
_NULLABLE = either(is_null, {"null": type(None), "value": Number})
_VECTOR, _MATRIX = list[_NULLABLE], list[list[_NULLABLE]]


def _complete(fields: dict[str, Any]) -> dict[str, Any]:
    return {name: (kind, ...) for name, kind in fields.items()}


_PAIR = Field(min_length=2, max_length=2)
_FREE = {
    "start": Number,
    "low": Number,
    "high": Number,
    "scale": Literal["linear", "log"],
    "prior": either(is_null, {"null": type(None), "value": Annotated[list[Number], _PAIR]}),
}
_TIE = {"to": Text, "factor": Number}
_WIDTHS = {field.name: NotNegative for field in dataclasses.fields(Widths)}
_SOFT = {"temperature": Positive, "widths": table("Widths", _WIDTHS)}
_THRESHOLDS = {
    kind: table(kind, {"kind": (names([kind]), ...)} | _complete({} if kind == "Hard" else _SOFT))
    for kind in ("Hard", "Soft", "StraightThrough")
}
_RUN = {
    "start": list[Number],
    "z": list[Number],
    "start_loss": _NULLABLE,
    "loss": _NULLABLE,
    "soft_loss": _NULLABLE,
    "history": _MATRIX,
    "result": Text,
}
_UNCERTAINTY = {
    **dict.fromkeys(("values", "slopes", "standard_errors", "gradient", "spectrum"), _VECTOR),
    **dict.fromkeys(("intervals", "covariance", "correlation", "information", "covariance_z", "directions"), _MATRIX),
    **dict.fromkeys(("variance", "n_effective", "degrees_of_freedom", "chi2", "reduced_chi2", "aic", "bic"), _NULLABLE),
    "determined": list[Truth],
    "on_bound": list[Annotated[Whole, Field(ge=-1, le=1)]],
    "absolute": Truth,
    "reason": Text,
    "confidence": Number,
}
_CURVE = {"condition": (Text, ...), "channel": (names(TARGETS), ...), "quote": Text}
_FIT = {
    "format": Literal["lgmd2jax-fit"],
    "version": Annotated[Whole, Field(ge=1, le=1)],
    "result": Text,
    "free": Annotated[dict[Text, table("Free_parameter", _complete(_FREE), OpenTable)], Field(min_length=1)],
    "ties": dict[Text, table("Tie", _complete(_TIE))],
    "observation": table("Observation", _complete(dict.fromkeys(observation_symbols(), Number))),
    "loss": _NULLABLE,
    "soft_loss": _NULLABLE,
    "temperatures": Annotated[list[Positive], Field(min_length=1)],
    "thresholds": by_key("kind", _THRESHOLDS),
    "curves": list[table("Curve", _CURVE, OpenTable)],
    "z": list[Number],
    "uncertainty": table("Uncertainty", _complete(_UNCERTAINTY)),
    "curved": list[Text],
    "leave_one_out_r2": dict[Text, _NULLABLE],
    "errors": dict[Text, _NULLABLE],
    "stats": dict[Text, Any],
    "runs": list[table("Run", _complete(_RUN))],
    "screened": _VECTOR,
}
_DATA = table("Data", dict.fromkeys(("file", "digest", "protocol", "animal"), Text))
FIT = TypeAdapter(table("Fit", _complete(_FIT) | {"unfinished": list[Text], "data": _DATA}, OpenTable))

_END = either(is_null, {"null": type(None), "value": OpenEnd})
_ROW = {"condition": Text, "channel": names(TARGETS), "time_ms": Number}
_ROW |= {"target": _END, "sem": _NULLABLE, "weight": Number, "soft": _NULLABLE, "hard": _NULLABLE, "band": _NULLABLE}
_ROW_TABLE = table("Row", _complete(_ROW) | {"error": _NULLABLE, "upper": _END, "exposure": _NULLABLE})
_ROWS: Any = Annotated[list[_ROW_TABLE], Field(min_length=1)]  # pyright: ignore[reportInvalidTypeForm]
ROWS = TypeAdapter(_ROWS)
