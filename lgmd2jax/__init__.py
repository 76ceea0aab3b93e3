"""The LGMD2 collision detector of juvenile locusts, differentiable in JAX: `import lgmd2jax as lgmd`."""

from lgmd2jax import alarms as alarms, fitting as fitting, stimuli as stimuli
from lgmd2jax._ablation import ABLATIONS as ABLATIONS, ablate as ablate
from lgmd2jax._characterise import (
    Characterisation as Characterisation,
    Finding as Finding,
    ablations as ablations,
    characterise as characterise,
    rasters as rasters,
)
from lgmd2jax._export import load as load, save as save
from lgmd2jax._eye import Eye as Eye
from lgmd2jax._frame_rate import at_frame_rate as at_frame_rate
from lgmd2jax._looming_law import LoomingLaw as LoomingLaw
from lgmd2jax._model import LGMD2 as LGMD2
from lgmd2jax._model_target import ModelTarget as ModelTarget
from lgmd2jax._network import Network as Network, Response as Response, State as State
from lgmd2jax._observation import Observation as Observation, observation_symbols as observation_symbols
from lgmd2jax._parameters import (
    PRESETS as PRESETS,
    Parameters as Parameters,
    Symbol as Symbol,
    preset as preset,
    symbols as symbols,
)
from lgmd2jax._pixels import Layers as Layers
from lgmd2jax._protocol import Condition as Condition, Protocol as Protocol, load_protocol as load_protocol
from lgmd2jax._recipe import Recipe as Recipe, load_recipe as load_recipe
from lgmd2jax._rest import Onset as Onset, Rest as Rest
from lgmd2jax._results import load_fit as load_fit, save_fit as save_fit
from lgmd2jax._spike_trains import SpikeTrains as SpikeTrains, spike_rate as spike_rate
from lgmd2jax._sweep import surfaces as surfaces, sweep as sweep
from lgmd2jax._target import Target as Target
from lgmd2jax._target_files import read_spike_trains as read_spike_trains, read_target as read_target
from lgmd2jax._thresholds import (
    Hard as Hard,
    Soft as Soft,
    StraightThrough as StraightThrough,
    Thresholds as Thresholds,
    Widths as Widths,
)
from lgmd2jax._weighted import Weighted as Weighted
from lgmd2jax._yue_rind import (
    YueRindLayers as YueRindLayers,
    YueRindLGMD1 as YueRindLGMD1,
    YueRindParameters as YueRindParameters,
)
from lgmd2jax.fitting import (
    Fit as Fit,
    Free as Free,
    Linear as Linear,
    Log as Log,
    Tie as Tie,
    fit as fit,
)
from lgmd2jax.stimuli import Stimulus as Stimulus
