"""The form of a file of labelled clips."""

from typing import Annotated

from pydantic import Field, TypeAdapter

from lgmd2jax._schemas.parts import Count, NotNegative, Positive, Side, Text, Truth, table
from lgmd2jax._schemas.sections import FRAME_RATE, RENDERING, eye

_PAIR = Field(min_length=2, max_length=2)
_STRETCHES = list[Annotated[list[Count], _PAIR]]  # first and last frame

_CLIP = {
    "file": (Text, ...),
    "name": Text,
    "fps": FRAME_RATE,
    "resize": Side,
    "crop": Text,
    "drop_duplicates": Truth,
    "white": Positive,
    "until_damage": Truth,
    "alarm": _STRETCHES,
    "silent": _STRETCHES,
    "contact": Count,
    "before_ms": Annotated[list[NotNegative], _PAIR],
    "grace_ms": NotNegative,
    "settle": Count,
    "source": Text,
    "weight": Positive,
}
LABELS = TypeAdapter(
    table("Labelled_clips", {"eye": (eye(), ...), "clip": list[table("Clip", _CLIP)], "rendered": RENDERING})
)
