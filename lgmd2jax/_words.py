"""Words of errors and of warnings; and which errors are a user's."""

import contextlib
import difflib
import sys
import warnings
from collections.abc import Iterable, Iterator
from opcode import opname

# Packages whose frames lie between a user's line and ours.
_WITHIN = ("lgmd2jax", "beartype", "contextlib", "dataclasses", "equinox", "functools", "jax", "jaxtyping")


class Remark(UserWarning):
    """What a user should know of something that can be used all the same. The command line prints it as a line."""


class UnfinishedWarning(Remark):
    """A fit was stopped before all that was asked for was done."""


def nearest(name: str, known: Iterable[str], count: int | None = None) -> str:
    """The valid names, the likeliest first, for an error message: all, or so many of them."""
    names = sorted(known, key=lambda other: -difflib.SequenceMatcher(None, str(name), other).ratio())[:count]
    *others, last = map(repr, names) if names else ("",)
    return f"{', '.join(others)} or {last}" if others else last


def warn(text: str, kind: type[Warning] = UserWarning) -> None:
    """Warn, with the place outside of the library that led here, however many calls lie between."""
    frame, level = sys._getframe(1), 2
    while frame is not None and frame.f_globals.get("__name__", "").partition(".")[0] in _WITHIN:
        frame, level = frame.f_back, level + 1
    warnings.warn(text, kind, stacklevel=level)


def warn_renamed(old: str, new: str) -> None:
    """Warn the caller of the function that calls this one that an old name is used."""
    warn(f"{old} is now {new}; the old name will be removed", DeprecationWarning)


def warn_unfinished(sentence: str) -> None:
    """Warn that results are not whole yet, and say how to go on."""
    warn(f"{sentence}; lgmd2jax fit ... --resume continues it", UnfinishedWarning)


def is_refusal(error: BaseException) -> bool:
    """Whether a `raise` statement of this package made the error, and so wrote its message for the user.

    What Python or another package raises is a fault of the program, also where a line of ours asked for it. The
    instruction tells the two apart, since JAX cuts its own frames out of a traceback.
    """
    innermost = error.__traceback__
    while innermost is not None and innermost.tb_next is not None:
        innermost = innermost.tb_next
    if innermost is None:
        return False
    package = innermost.tb_frame.f_globals.get("__name__", "").partition(".")[0]
    instruction = innermost.tb_frame.f_code.co_code[innermost.tb_lasti]
    return package == "lgmd2jax" and opname[instruction] == "RAISE_VARARGS"


@contextlib.contextmanager
def within(place: str) -> Iterator[None]:
    """Name the place in every refusal that leaves the block. A fault of the library leaves it as it is."""
    try:
        yield
    except (ValueError, FileNotFoundError) as error:
        if not is_refusal(error):
            raise
        kind = ValueError if isinstance(error, ValueError) else FileNotFoundError
        raise kind(f"{place}: {error}") from error
