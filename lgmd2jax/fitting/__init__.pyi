# The public names. `__init__.py` loads each of them when it is first used.
from ._animal_fits import AnimalFits as AnimalFits, Population as Population
from ._animals import fit_each as fit_each
from ._bounds import Linear as Linear, Log as Log
from ._comparison import Comparison as Comparison
from ._conditions import AnyTarget as AnyTarget
from ._curve import Curve as Curve
from ._fit import fit as fit
from ._free import Free as Free, ParameterSet as ParameterSet, Tie as Tie
from ._law_fit import LawComparison as LawComparison, LawFit as LawFit, PeakLine as PeakLine
from ._result import Fit as Fit
from ._run import Run as Run
from ._simulator import Simulator as Simulator, as_simulator as as_simulator
from ._solver.levenberg_marquardt import BoundedLevenbergMarquardt as BoundedLevenbergMarquardt
from ._supplement import Supplement as Supplement
from ._telling import (
    TellingStimulus as TellingStimulus,
    discriminating_stimulus as discriminating_stimulus,
    strongest_stimulus as strongest_stimulus,
)
from ._uncertainty.covariance import Uncertainty as Uncertainty
from ._uncertainty.next_stimulus import Candidate as Candidate
from ._uncertainty.posterior import Posterior as Posterior
from ._uncertainty.profile import Profile as Profile
from ._uncertainty.random_effects import RandomEffects as RandomEffects, random_effects as random_effects
from ._uncertainty.score import Score as Score
