"""Fitting the model to response curves."""

from lgmd2jax._network.parameters import ParameterSet as ParameterSet
from lgmd2jax._targets.target import AnyTarget as AnyTarget
from lgmd2jax.fitting._curve import Curve as Curve
from lgmd2jax.fitting._fit import fit as fit
from lgmd2jax.fitting._free import Free as Free, Linear as Linear, Log as Log, Tie as Tie
from lgmd2jax.fitting._law_fit import LawComparison as LawComparison, LawFit as LawFit, PeakLine as PeakLine
from lgmd2jax.fitting._report import Supplement as Supplement
from lgmd2jax.fitting._result import Fit as Fit
from lgmd2jax.fitting._run import Run as Run
from lgmd2jax.fitting._solver.levenberg_marquardt import BoundedLevenbergMarquardt as BoundedLevenbergMarquardt
from lgmd2jax.fitting._uncertainty.covariance import Uncertainty as Uncertainty
from lgmd2jax.fitting._uncertainty.next_stimulus import Candidate as Candidate
from lgmd2jax.fitting._uncertainty.posterior import Posterior as Posterior
from lgmd2jax.fitting._uncertainty.profile import Profile as Profile
