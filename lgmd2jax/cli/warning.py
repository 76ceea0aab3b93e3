"""How a command warns: one line, beside its results."""

import sys


def warn(text: object) -> None:
    """Print it to the standard error."""
    print(f"lgmd2jax: warning: {text}", file=sys.stderr)
