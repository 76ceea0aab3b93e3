# The public names. `__init__.py` loads each of them when it is first used.
from ._clip import ClipLabels as ClipLabels, LabelledClip as LabelledClip
from ._comparison import Comparison as Comparison, Detector as Detector
from ._counts import Counts as Counts, Score as Score, Share as Share
from ._detectors import detectors as detectors
from ._evaluation import (
    Evaluation as Evaluation,
    HeldOutScores as HeldOutScores,
    Verdict as Verdict,
    evaluate as evaluate,
)
from ._evidence import evidence as evidence
from ._fit import fit as fit
from ._label_file import LabelFile as LabelFile, Rendering as Rendering, load_labels as load_labels
from ._reasons import Drive as Drive, FalseAlarm as FalseAlarm, Miss as Miss
from ._recipe import AlarmRecipe as AlarmRecipe, load_recipe as load_recipe
from ._reliability import Reliability as Reliability
from ._result import AlarmFit as AlarmFit
from ._starts import AlarmDescent as AlarmDescent
from ._urgency import Urgency as Urgency, fit_urgency as fit_urgency, load_urgency as load_urgency
