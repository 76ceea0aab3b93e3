"""What a user should know of a clip that can be used all the same."""

import lgmd2jax._words as words


class ClipWarning(words.Remark):
    """A clip is read otherwise than one might think."""


def warn(text: str) -> None:
    """Say it once, with the place where the clip was opened or read."""
    words.warn(text, ClipWarning)
