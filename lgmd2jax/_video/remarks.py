"""What a user should know of a clip that can be used all the same."""

import warnings

from lgmd2jax._words import Remark


class ClipWarning(Remark):
    """A clip is read otherwise than one might think."""


def warn(text: str) -> None:
    """Say it once, with the place where the clip was opened or read."""
    warnings.warn(text, ClipWarning, stacklevel=3)
