"""Fits to labelled clips: an alarm in time, silence otherwise.

`load_labels` reads a file of labelled clips, `fit` fits a model to them, `evaluate` says how well a model does on them.
"""

from typing import Any

import lazy_loader

from lgmd2jax._words import warn_renamed

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
_RENAMED = {
    "Footage": "LabelledClip",
    "footage": "LabelledClip.of",
    "FootageFile": "LabelFile",
    "load_footage": "load_labels",
    "Rendered": "Rendering",
    "rendered": "Rendering.clips",
    "Watch": "Evaluation",
    "watch": "evaluate",
    "Held": "HeldOutScores",
}


def __getattr__(name: str) -> Any:
    """A public name, loaded when first used; an old one with a warning."""
    if name not in _RENAMED:
        return _load(name)
    warn_renamed(f"lgmd2jax.alarms.{name}", f"lgmd2jax.alarms.{_RENAMED[name]}")
    if name == "rendered":
        return lambda eye, wanted: iter(()) if wanted is None else wanted.clips(eye)
    first, *attributes = _RENAMED[name].split(".")
    value = _load(first)
    for attribute in attributes:
        value = getattr(value, attribute)
    return value
