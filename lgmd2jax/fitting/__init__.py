"""Fitting the model to response curves."""

from lgmd2jax.fitting._curve import Curve as Curve
from lgmd2jax.fitting._descent import Run as Run
from lgmd2jax.fitting._fit import fit as fit
from lgmd2jax.fitting._free import Free as Free, Linear as Linear, Log as Log, Tie as Tie
from lgmd2jax.fitting._result import Fit as Fit
from lgmd2jax.fitting._solver.levenberg_marquardt import BoundedLevenbergMarquardt as BoundedLevenbergMarquardt
