"""What schemas consist of: strict numbers and texts, tables of known keys, a choice by what a table holds."""

import math
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal

from annotated_types import Ge, Gt, Le, Lt
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    Strict,
    create_model,
    model_validator,
)
from pydantic_core import PydanticCustomError, core_schema

MOST_PIXELS = 10_000  # along a side of a frame
MOST_VALUES = 10_000  # along an axis


def _no_nan(value: float) -> float:
    if math.isnan(value):
        raise ValueError("must be a number")
    return value


Number = Annotated[float, Strict(), Field(allow_inf_nan=False)]
OpenEnd = Annotated[float, Strict(), AfterValidator(_no_nan)]  # infinite where there is no end
Positive = Annotated[Number, Gt(0)]
NotNegative = Annotated[Number, Ge(0)]
Whole = Annotated[int, Strict()]
Count = Annotated[Whole, Ge(0), Le(10**9)]
Seed = Annotated[Whole, Ge(0), Le(2**32 - 1)]  # what JAX takes also without its 64 bits
Truth = Annotated[bool, Strict()]
Text = Annotated[str, Strict()]
Side = Annotated[Whole, Ge(3), Le(MOST_PIXELS)]


class Table(BaseModel):
    """A table of a document, which has no other keys than these fields."""

    model_config = ConfigDict(extra="forbid", protected_namespaces=(), defer_build=True)

    @model_validator(mode="before")
    @classmethod
    def _known(cls, content: Any) -> Any:
        """Refuse the first key that is none."""
        if isinstance(content, Mapping):
            known = list(cls.model_fields)
            for key in content:
                if key not in known:
                    raise PydanticCustomError("unknown_key", "unknown key", {"path": (key,), "known": known})
        return content


class OpenTable(BaseModel):
    """A table of a document, which may have other keys than these fields."""

    model_config = ConfigDict(extra="allow", protected_namespaces=(), defer_build=True)


def table(name: str, fields: Mapping[str, Any], base: type[BaseModel] = Table) -> type[BaseModel]:
    """A table, by the type of each key; what is a pair of type and `...` must be given."""
    optional: dict[str, Any] = {key: kind if isinstance(kind, tuple) else (kind, None) for key, kind in fields.items()}
    return create_model(name, __base__=base, **optional)


def inside(domain: str) -> Any:
    """A number in a domain such as `"(0, inf)"`, square brackets where an end belongs to it."""
    low, high = map(float, domain[1:-1].split(","))
    above = [(Ge if domain[0] == "[" else Gt)(low)] if low > -float("inf") else []
    below = [(Le if domain[-1] == "]" else Lt)(high)] if high < float("inf") else []
    kind: Any = Number
    for limit in (*above, *below):
        kind = Annotated[kind, limit]
    return kind


def names(known) -> Any:
    """One of these texts."""
    return Literal[tuple(known)]


class _Either:
    """Tells pydantic by which function one of several forms is chosen."""

    def __init__(self, choose: Callable[[Any], str | None], branches: Mapping[str, Any], unknown: dict[str, Any]):
        self._choose, self._branches, self._unknown = choose, branches, unknown

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        # In angle brackets the name of the branch, which pydantic puts into the path of an error, is known from a key.
        return core_schema.tagged_union_schema(
            {f"<{name}>": handler.generate_schema(kind) for name, kind in self._branches.items()},
            lambda content: f"<{self._choose(content)}>",
            custom_error_type="one_of",
            custom_error_message="choose one",
            custom_error_context=self._unknown,
        )


def either(choose: Callable[[Any], str | None], branches: Mapping[str, Any], **unknown: Any) -> Any:
    """What has one of several forms, of which its content tells which: the others are not tried.

    **Arguments:** `unknown`: what an error says where `choose` gives None.
    """
    return Annotated[Any, _Either(choose, branches, unknown)]


def by_key(key: str, branches: Mapping[str, Any], default: str | None = None) -> Any:
    """A table whose form the text at one of its keys decides."""
    first = next(iter(branches))

    def chosen(content: Any) -> str | None:
        if not isinstance(content, Mapping):
            return first  # which refuses what is no table
        name = content.get(key, default)
        return name if isinstance(name, str) and name in branches else None

    return either(chosen, branches, path=(key,), known=list(branches))


def several(kind: Any) -> Any:
    """A value, or a list of some as an axis of a grid."""
    return either(is_list, {"value": kind, "list": Annotated[list[kind], Field(min_length=1, max_length=MOST_VALUES)]})


def is_null(content: Any) -> str:
    """The branch of `either` for null, or for a value."""
    return "null" if content is None else "value"


def is_list(content: Any) -> str:
    """The branch of `either` for a list, or for a single value."""
    return "list" if isinstance(content, list) else "value"
