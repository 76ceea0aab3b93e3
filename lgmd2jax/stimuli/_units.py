"""Units of what renderers take: declared by the type of an argument, read for messages and for the axes of a sweep."""

import dataclasses
import inspect
import math
import typing
from collections.abc import Callable, Iterator
from typing import Annotated, Any

from jaxtyping import ScalarLike
from typing_extensions import TypeAliasType

from lgmd2jax._words import warn


@dataclasses.dataclass(frozen=True)
class Confusion:
    """Another unit, in which users give a number by mistake: its name, its size, and the numbers that betray it."""

    name: str
    size: float
    betrayed_by: Callable[[float], bool]


@dataclasses.dataclass(frozen=True)
class Unit:
    """A unit as messages write it, and the other one that it is confused with."""

    name: str
    confusion: Confusion | None = None

    def warn_if_confused(self, argument: str, value: float) -> None:
        """Warn of a value that is hardly meant in this unit."""
        other = self.confusion
        if other is not None and other.betrayed_by(value):
            meant = f"{other.size * value:.4g} {self.name}"
            warn(f"{argument} is {value:.4g} {self.name}; was {meant} meant, given {other.name}?")


def _is_angle_in_radians(value: float) -> bool:
    """Whether it is a multiple of a quarter degree to nine digits: nobody asks for 1.0471975512 degrees."""
    quarters = 4 * math.degrees(value)
    return value != 0 and abs(quarters - round(quarters)) < 1e-9


_SECONDS = Confusion("in seconds", 1000.0, lambda value: 0 < value < 1)
_RADIANS = Confusion("in radians", math.degrees(1), _is_angle_in_radians)
_SHARES = Confusion("in 0..1", 255.0, lambda value: 0 < value < 1)

Milliseconds = TypeAliasType("Milliseconds", Annotated[ScalarLike, Unit("ms", _SECONDS)])
Degrees = TypeAliasType("Degrees", Annotated[ScalarLike, Unit("degrees", _RADIANS)])
DegreesPerSecond = TypeAliasType("DegreesPerSecond", Annotated[ScalarLike, Unit("deg/s", _RADIANS)])
Pixels = TypeAliasType("Pixels", Annotated[ScalarLike, Unit("px")])
PixelsPerSecond = TypeAliasType("PixelsPerSecond", Annotated[ScalarLike, Unit("px/s")])
PixelsPerSecond2 = TypeAliasType("PixelsPerSecond2", Annotated[ScalarLike, Unit("px/s2")])
Centimetres = TypeAliasType("Centimetres", Annotated[ScalarLike, Unit("cm")])
CentimetresPerSecond = TypeAliasType("CentimetresPerSecond", Annotated[ScalarLike, Unit("cm/s")])
GreyLevel = TypeAliasType("GreyLevel", Annotated[ScalarLike, Unit("grey levels", _SHARES)])
GreyLevelDeviation = TypeAliasType("GreyLevelDeviation", Annotated[ScalarLike, Unit("grey levels")])
WeberContrast = TypeAliasType("WeberContrast", Annotated[ScalarLike, Unit("(Weber)")])
MichelsonContrast = TypeAliasType("MichelsonContrast", Annotated[ScalarLike, Unit("(Michelson)")])
Factor = TypeAliasType("Factor", Annotated[ScalarLike, Unit("(factor)")])
ShareOfField = TypeAliasType("ShareOfField", Annotated[ScalarLike, Unit("of the field")])
ShareOfLight = TypeAliasType("ShareOfLight", Annotated[ScalarLike, Unit("of the light")])
CyclesPerDegree = TypeAliasType("CyclesPerDegree", Annotated[ScalarLike, Unit("cycles per degree")])
CyclesPerImage = TypeAliasType("CyclesPerImage", Annotated[ScalarLike, Unit("per image")])
Hertz = TypeAliasType("Hertz", Annotated[ScalarLike, Unit("Hz")])


def unit_of(quantity: TypeAliasType) -> Unit:
    """The unit of a quantity such as `Milliseconds`."""
    return quantity.__value__.__metadata__[0]


def parts_of(annotation: Any) -> Iterator[Any]:
    """The single types that an annotation allows, and what it declares of them: aliases and unions taken apart."""
    if isinstance(annotation, TypeAliasType):
        yield from parts_of(annotation.__value__)
    elif parts := typing.get_args(annotation):
        for part in parts:
            yield from parts_of(part)
    else:
        yield annotation


def units_of(renderer: Callable) -> dict[str, str]:
    """The units of a renderer's arguments by name, without the brackets that messages put around some."""
    return {
        name: part.name.strip("()")
        for name, parameter in inspect.signature(inspect.unwrap(renderer)).parameters.items()
        for part in parts_of(parameter.annotation)
        if isinstance(part, Unit)
    }
