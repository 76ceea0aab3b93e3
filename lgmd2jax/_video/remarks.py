"""What a user should know of a clip that can be used all the same."""

import contextlib
import sys
import warnings
from collections.abc import Iterator


class ClipWarning(UserWarning):
    """A clip is read otherwise than one might think. The command line prints it as a line."""


def warn(text: str) -> None:
    """Say it once, with the place where the clip was opened or read."""
    warnings.warn(text, ClipWarning, stacklevel=3)


@contextlib.contextmanager
def clip_warnings_as_lines() -> Iterator[None]:
    """Within the block a `ClipWarning` is one line on standard error, as the command line's own warnings are."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", ClipWarning)
        show = warnings.showwarning

        def line(message, category, *place, **rest):
            if issubclass(category, ClipWarning):
                print(f"lgmd2jax: warning: {message}", file=sys.stderr)
            else:
                show(message, category, *place, **rest)

        warnings.showwarning = line
        yield
