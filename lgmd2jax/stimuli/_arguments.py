"""Arguments of the renderers: numbers made arrays, and refused where they cannot be meant. Traced ones go unchecked."""

import math
from collections.abc import Callable, Collection, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import ScalarLike
from typing_extensions import TypeAliasType

from lgmd2jax._eye import Eye
from lgmd2jax._types import Scalar, is_concrete
from lgmd2jax._words import nearest
from lgmd2jax.stimuli._units import Degrees, Pixels, unit_of


def number(
    name: str, value: ScalarLike | None, quantity: TypeAliasType, low: float | int = -np.inf, high: float | int = np.inf
) -> Scalar:
    """A floating scalar in [low, high], in the unit of a quantity such as `Milliseconds`.

    Warns of a value that is hardly meant in that unit.

    **Raises:** `ValueError` for another shape, and for a concrete value outside of the range.
    """
    span = f"in {low:g}..{high:g}" if np.isfinite(high) else "finite" if np.isinf(low) else f"of {low:g} or more"
    return _checked(name, value, quantity, {f"a number {span}": lambda size: low <= size <= high})


def positive(name: str, value: ScalarLike | None, quantity: TypeAliasType, high: float | int = np.inf) -> Scalar:
    """A floating scalar in (0, high], as `number`.

    **Raises:** `ValueError` for another shape, and for a concrete value that is not positive, not finite or too large.
    """
    wanted = {"a positive number": lambda size: size > 0, f"a number in 0..{high:g}": lambda size: size <= high}
    return _checked(name, value, quantity, wanted)


def _checked(
    name: str, value: ScalarLike | None, quantity: TypeAliasType, wanted: Mapping[str, Callable[[float], bool]]
) -> Scalar:
    """The value as an array, refused with the first of the `wanted` words that are not true of it."""
    unit = unit_of(quantity)
    if not _is_number(value):
        cure = f"give one number, in {unit.name.strip('()')}, and map a batch with jax.vmap"
        raise ValueError(f"{name} is {value!r:.60}; {cure}")
    if is_concrete(value):
        size = float(np.asarray(value))
        for words, holds in wanted.items():
            if not (math.isfinite(size) and holds(size)):
                raise ValueError(f"{name} is {value} {unit.name}; give {words}")
        unit.warn_if_confused(name, size)
    return jnp.asarray(value, dtype=float)


def _is_number(value: Any) -> bool:
    """Whether it is one number without a unit of its own, which numpy would drop; a traced one too."""
    if isinstance(value, bool):
        return False
    if isinstance(value, (int, float)):
        return True
    # Quantities are a kind of numpy's array.
    is_array = isinstance(value, (np.generic, jax.Array)) or type(value) is np.ndarray
    return is_array and not value.shape and value.dtype.kind in "iuf"


def one_of(name: str, value: str, known: Collection) -> None:
    """Refuse a value that is not known, offering the likeliest."""
    if value not in known:
        raise ValueError(f"{name} is {value!r}; choose {nearest(value, known)}")


def check_fits(eye: Eye, name: str, extent_px: Scalar) -> None:
    """Refuse an object of `extent_px` that is larger than the field's smaller side, where that is not meant."""
    field = min(eye.rows, eye.cols)
    if is_concrete(extent_px) and float(extent_px) > field:
        raise ValueError(f"{name} makes an object of {extent_px:.4g} px, beyond the field of {field} px; shrink it")


def all_given(**values) -> bool:
    """Whether all of these arguments are given, or none is.

    **Raises:** `ValueError` where only some are.
    """
    missing = [name for name, value in values.items() if value is None]
    if missing and len(missing) < len(values):
        first = next(name for name in values if name not in missing)
        raise ValueError(f"{first} is given without {missing[0]}; give all of {', '.join(values)}, or none")
    return not missing


def extent_px(eye: Eye, name: str, degrees: Degrees, pixels: Pixels | None) -> Scalar:
    """An object's extent in pixels, given so or as a full angle; it must be smaller than the field.

    **Raises:** `ValueError` for an extent that is not positive or larger than the field.
    """
    if pixels is not None:
        name, extent = f"{name}_px", positive(f"{name}_px", pixels, Pixels)
    else:
        extent = 2 * eye.project(positive(name, degrees, Degrees) / 2)
    check_fits(eye, name, extent)
    return extent
