"""Numbers with a unit of their own, as neo, quantities, pint, astropy, brian2, pynapple, pandas and xarray give them.

None of these packages is needed: each kind is known by the method that converts it.
"""

import datetime
from typing import Any, Literal

import numpy as np
from typing_extensions import TypeAliasType

Unit = Literal["ms", "Hz", "1"]

# How much of the unit each word is, as column headers and attributes write it.
_WORDS: dict[Unit, dict[str, float]] = {
    "ms": {
        **dict.fromkeys(("ns", "nsec", "nanosecond", "nanoseconds"), 1e-6),
        **dict.fromkeys(("us", "\N{MICRO SIGN}s", "\N{GREEK SMALL LETTER MU}s", "usec", "microseconds"), 1e-3),
        **dict.fromkeys(("ms", "msec", "msecs", "millisecond", "milliseconds"), 1.0),
        **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1e3),
        **dict.fromkeys(("min", "mins", "minute", "minutes"), 6e4),
    },
    "Hz": {
        **dict.fromkeys(("hz", "1/s", "s-1", "s^-1", "spikes/s", "spikes/sec", "sp/s"), 1.0),
        **dict.fromkeys(("khz", "1/ms", "ms-1", "ms^-1", "spikes/ms"), 1e3),
    },
    "1": dict.fromkeys(("", "1", "dimensionless"), 1.0),
}
_BRIAN: dict[Unit, tuple[str, float]] = {"ms": ("second", 1e3), "Hz": ("second ** -1", 1.0), "1": ("Dimension()", 1.0)}
_KINDS = {"m": "durations", "M": "dates"}


# A time in ms, or with a unit of its own, of which `duration` makes one in ms.
Duration = TypeAliasType("Duration", float | int | Any)


def times(values: Any, name: str) -> np.ndarray:
    """The values as floats in ms; what has no unit of its own is taken to be in ms already.

    **Raises:** `ValueError`, which begins with `name`, for a unit of something else, for dates, and for no numbers.
    """
    return _converted(values, ("ms",), name, "times in ms, or with a unit of their own")


def levels(values: Any, name: str) -> np.ndarray:
    """The values as floats: rates in spikes/s, all else plain.

    **Raises:** as `times`.
    """
    return _converted(values, ("Hz", "1"), name, "numbers")


def duration(value: Any, name: str) -> Any:
    """A single time in ms where it has a unit of its own; else what is given, unchanged.

    **Raises:** as `times`.
    """
    return float(times(value, name)) if has_unit(value) else value


def has_unit(values: Any) -> bool:
    """Whether the values, or one of a list of them, have a unit of their own, which numpy would drop."""
    if values is None or isinstance(values, (int, float, str, bytes)):
        return False
    if isinstance(values, (list, tuple)):
        return any(has_unit(value) for value in values)
    if isinstance(values, (datetime.timedelta, datetime.date)) or _kind(values) in _KINDS:
        return True
    if type(values) is np.ndarray:
        return values.dtype == object and has_unit(values.ravel().tolist())
    if _written(values) is not None:
        return True
    return any(hasattr(values, method) for method in ("rescale", "m_as", "to_value", "has_same_dimensions"))


def size_of(word: str, unit: Unit) -> float | None:
    """How many of `unit` one of `word` is; None for a word that is no name of such a unit."""
    return _WORDS[unit].get(word.strip().lower())


def _converted(values: Any, units: tuple[Unit, ...], name: str, wanted: str) -> np.ndarray:
    reasons = []
    for unit in units:
        try:
            return _in_unit(values, unit)
        except _NoNumbersError:
            raise ValueError(f"{name} is {' '.join(repr(values).split()):.40}; give {wanted}") from None
        except (TypeError, ValueError, AttributeError) as error:
            reasons.append(" ".join(str(error).split()))
    raise ValueError(f"{name} has another unit than {' or '.join(units)}: {reasons[0]:.80}; give {wanted}")


class _NoNumbersError(Exception):
    """What is to be converted holds something else than numbers."""


def _in_unit(values: Any, unit: Unit) -> np.ndarray:
    plain = "dimensionless" if unit == "1" else unit
    if hasattr(values, "rescale"):  # quantities, neo
        return np.asarray(values.rescale(plain).magnitude, dtype=float)
    if hasattr(values, "m_as"):  # pint
        return np.asarray(values.m_as(plain), dtype=float)
    if hasattr(values, "to_value"):  # astropy, unyt
        return np.asarray(values.to_value("" if unit == "1" else unit), dtype=float)
    if hasattr(values, "has_same_dimensions"):  # brian2, which keeps SI units
        return _of_brian(values, unit)
    if callable(getattr(values, "times", None)) and unit == "ms":  # pynapple, which counts in seconds
        return 1e3 * np.asarray(values.times(), dtype=float)
    if (word := _written(values)) is not None:  # xarray
        size = size_of(str(word), unit)
        if size is None:
            raise ValueError(f"the attribute units is {word!r}")
        return np.asarray(size * _plain(values, unit))
    if isinstance(values, (list, tuple)) and has_unit(values):
        return np.array([_in_unit(value, unit) for value in values])
    return _plain(values, unit)


def _plain(values: Any, unit: Unit) -> np.ndarray:
    """What numpy knows: numbers, and its own and pandas' durations."""
    if isinstance(values, datetime.date):
        raise ValueError("these are dates")
    if hasattr(values, "to_timedelta64"):
        values = values.to_timedelta64()
    array = np.asarray(np.timedelta64(values) if isinstance(values, datetime.timedelta) else values)
    if array.dtype == object and has_unit(array):
        return np.array([_in_unit(value, unit) for value in array.ravel()]).reshape(array.shape)
    if array.dtype.kind == "m" and unit == "ms":
        return np.asarray(array.astype("timedelta64[ns]").astype(float) / 1e6)
    if array.dtype.kind in _KINDS:
        raise ValueError(f"these are {_KINDS[array.dtype.kind]}")
    if array.dtype.kind == "c":
        raise _NoNumbersError
    try:
        if isinstance(values, np.ma.MaskedArray):
            return np.ma.filled(values.astype(float), np.nan)
        return array.astype(float)
    except (TypeError, ValueError):
        raise _NoNumbersError from None


def _of_brian(values: Any, unit: Unit) -> np.ndarray:
    dimension, size = _BRIAN[unit]
    if repr(values.dim) != dimension:
        raise ValueError(f"the dimension is {values.dim!r}")
    return np.asarray(size * np.asarray(values, dtype=float))


def _kind(values: Any) -> str:
    """The letter of numpy's kind of an array, also of one of pandas."""
    return getattr(getattr(values, "dtype", None), "kind", "")


def _written(values: Any) -> Any:
    """The unit in the attributes of an array of xarray or pandas; None where there is none."""
    attributes = getattr(values, "attrs", None)
    return attributes.get("units") if isinstance(attributes, dict) else None
