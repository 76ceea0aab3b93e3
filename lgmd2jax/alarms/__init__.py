"""Fits to labelled clips: an alarm in time, silence otherwise.

`load_footage` reads clips with their labels, `fit` fits a model to them, `watch` says what a model does on them.
"""

from lgmd2jax.alarms._evidence import evidence as evidence
from lgmd2jax.alarms._fit import fit as fit
from lgmd2jax.alarms._footage import Footage as Footage, footage as footage
from lgmd2jax.alarms._footage_file import (
    FootageFile as FootageFile,
    Rendered as Rendered,
    load_footage as load_footage,
    rendered as rendered,
)
from lgmd2jax.alarms._recipe import AlarmRecipe as AlarmRecipe, load_recipe as load_recipe
from lgmd2jax.alarms._report import Held as Held
from lgmd2jax.alarms._result import AlarmFit as AlarmFit
from lgmd2jax.alarms._watch import Score as Score, Verdict as Verdict, Watch as Watch, watch as watch
