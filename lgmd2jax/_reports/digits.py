"""Numbers with the digits that their errors justify."""

import math

_EXACT = 1e-6  # relative error below which more digits tell nothing


def measured(value: float, error: float) -> str:
    """Value and standard error, such as `3.21 +- 0.15`; the value alone where there is no error to be told."""
    if not _tells(value, error):
        return plain(value)
    if error < _EXACT * abs(value):
        return f"{value:.6g} +- {error:.1g}"
    decimals, exponent = _decimals(error, value), _exponent(value, error)
    return f"{_fixed(value, decimals, exponent)} +- {_fixed(error, decimals, exponent)}"


def rounded(number: float, value: float, error: float) -> str:
    """A number, such as an end of an interval, in the decimals of a value with this standard error."""
    if not _tells(number, error) or error < _EXACT * abs(value):
        return plain(number)
    return _fixed(number, _decimals(error, value, number), _exponent(value, error))


def plain(number: float) -> str:
    """A number of which no error is known."""
    return f"{number:.4g}"


def _tells(number: float, error: float) -> bool:
    return math.isfinite(number) and math.isfinite(error) and error > 0


def _decimals(error: float, *numbers: float) -> int:
    """Two digits of the error, and of numbers that are smaller than it, but no endless row of them."""
    by_error = 1 - _magnitude(float(f"{error:.1e}"))
    by_numbers = [1 - _magnitude(number) for number in numbers if number]
    return min(max([by_error, *by_numbers]), by_error + 2)


def _exponent(value: float, error: float) -> int:
    largest = max(abs(value), error)
    return 0 if 1e-3 <= largest < 1e6 else _magnitude(largest)


def _fixed(number: float, decimals: int, exponent: int) -> str:
    decimals += exponent
    mantissa = round(number / 10.0**exponent, decimals) + 0.0  # never -0
    return f"{mantissa:.{max(decimals, 0)}f}" + (f"e{exponent}" if exponent else "")


def _magnitude(number: float) -> int:
    return math.floor(math.log10(abs(number)))
