"""Where the system wants files that can be made anew."""

import os
import sys
from pathlib import Path


def cache_folder() -> Path:
    """The user's folder for this package's cache; it need not be there."""
    if sys.platform == "win32":
        place = os.environ.get("LOCALAPPDATA", "~/AppData/Local")
    elif sys.platform == "darwin":
        place = "~/Library/Caches"
    else:
        place = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(place).expanduser() / "lgmd2jax"
