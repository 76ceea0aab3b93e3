# The public names. `__init__.py` loads each of them when it is first used.
from ._evidence import evidence as evidence
from ._fit import fit as fit
from ._footage import Footage as Footage, footage as footage
from ._footage_file import (
    FootageFile as FootageFile,
    Rendered as Rendered,
    load_footage as load_footage,
    rendered as rendered,
)
from ._recipe import AlarmRecipe as AlarmRecipe, load_recipe as load_recipe
from ._report import Held as Held
from ._result import AlarmFit as AlarmFit
from ._watch import Score as Score, Verdict as Verdict, Watch as Watch, watch as watch
