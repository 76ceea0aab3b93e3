"""Words of error messages."""

import difflib


def nearest(name: str, known) -> str:
    """The valid names, the likeliest first, for an error message."""
    names = sorted(known, key=lambda other: -difflib.SequenceMatcher(None, str(name), other).ratio())
    return " or ".join(repr(other) for other in names)
