"""Fits to labelled clips: an alarm in time, silence otherwise.

`load_labels` reads a file of labelled clips, `fit` fits a model to them, `evaluate` says how well a model does on them.
"""

from collections.abc import Iterator
from typing import Any

from lgmd2jax._eye import Eye
from lgmd2jax._words import warn_renamed
from lgmd2jax.alarms._clip import LabelledClip as LabelledClip
from lgmd2jax.alarms._evaluation import (
    Evaluation as Evaluation,
    HeldOutScores as HeldOutScores,
    Score as Score,
    Share as Share,
    Verdict as Verdict,
    evaluate as evaluate,
)
from lgmd2jax.alarms._evidence import evidence as evidence
from lgmd2jax.alarms._fit import fit as fit
from lgmd2jax.alarms._label_file import LabelFile as LabelFile, Rendering as Rendering, load_labels as load_labels
from lgmd2jax.alarms._recipe import AlarmRecipe as AlarmRecipe, load_recipe as load_recipe
from lgmd2jax.alarms._result import AlarmFit as AlarmFit
from lgmd2jax.alarms._starts import AlarmDescent as AlarmDescent


def _rendered(eye: Eye, wanted: Rendering | None) -> Iterator[LabelledClip]:
    return iter(()) if wanted is None else wanted.clips(eye)


_RENAMED = {
    "Footage": ("LabelledClip", LabelledClip),
    "footage": ("LabelledClip.of", LabelledClip.of),
    "FootageFile": ("LabelFile", LabelFile),
    "load_footage": ("load_labels", load_labels),
    "Rendered": ("Rendering", Rendering),
    "rendered": ("Rendering.clips", _rendered),
    "Watch": ("Evaluation", Evaluation),
    "watch": ("evaluate", evaluate),
    "Held": ("HeldOutScores", HeldOutScores),
}


def __getattr__(name: str) -> Any:
    """The old names, with a warning."""
    if name not in _RENAMED:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    new, value = _RENAMED[name]
    warn_renamed(f"lgmd2jax.alarms.{name}", f"lgmd2jax.alarms.{new}")
    return value
