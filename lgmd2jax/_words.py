"""Words of errors and of warnings."""

import difflib
import warnings


class Remark(UserWarning):
    """What a user should know of something that can be used all the same. The command line prints it as a line."""


class UnfinishedWarning(Remark):
    """A fit was stopped before all that was asked for was done."""


def nearest(name: str, known) -> str:
    """The valid names, the likeliest first, for an error message."""
    names = sorted(known, key=lambda other: -difflib.SequenceMatcher(None, str(name), other).ratio())
    return " or ".join(repr(other) for other in names)


def warn_renamed(old: str, new: str) -> None:
    """Warn the caller of the function that calls this one that an old name is used."""
    warnings.warn(f"{old} is now {new}; the old name will be removed", DeprecationWarning, stacklevel=3)
