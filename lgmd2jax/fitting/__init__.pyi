# The public names. `__init__.py` loads each of them when it is first used.
from ._curve import Curve as Curve
from ._descent import Run as Run
from ._fit import fit as fit
from ._free import Free as Free, Linear as Linear, Log as Log, Tie as Tie
from ._result import Fit as Fit
from ._solver.levenberg_marquardt import BoundedLevenbergMarquardt as BoundedLevenbergMarquardt
