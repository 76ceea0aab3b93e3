"""The LGMD2 collision detector of juvenile locusts, differentiable in JAX: `import lgmd2jax as lgmd`."""

from lgmd2jax import fitting as fitting, stimuli as stimuli
from lgmd2jax._ablation import ABLATIONS as ABLATIONS, ablate as ablate
from lgmd2jax._export import load as load, save as save
from lgmd2jax._eye import Eye as Eye
from lgmd2jax._model import LGMD2 as LGMD2, Layers as Layers, Response as Response, State as State
from lgmd2jax._parameters import (
    PRESETS as PRESETS,
    Parameters as Parameters,
    Symbol as Symbol,
    preset as preset,
    symbols as symbols,
)
from lgmd2jax._protocol import Condition as Condition, Protocol as Protocol, load_protocol as load_protocol
from lgmd2jax._thresholds import (
    Hard as Hard,
    Soft as Soft,
    StraightThrough as StraightThrough,
    Thresholds as Thresholds,
    Widths as Widths,
)
from lgmd2jax.stimuli import Stimulus as Stimulus
