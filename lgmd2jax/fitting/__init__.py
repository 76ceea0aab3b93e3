"""Fitting the model to response curves."""

from lgmd2jax.fitting._fit import Fit as Fit, fit as fit
from lgmd2jax.fitting._free import Free as Free
from lgmd2jax.fitting._observation import Observation as Observation
from lgmd2jax.fitting._target import Target as Target, read_target as read_target
