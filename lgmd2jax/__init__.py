"""The LGMD2 collision detector of juvenile locusts, differentiable in JAX: `import lgmd2jax as lgmd`."""

from lgmd2jax import alarms as alarms, fitting as fitting, stimuli as stimuli
from lgmd2jax._characterise import (
    Characterisation as Characterisation,
    Finding as Finding,
    ablations as ablations,
    characterise as characterise,
    rasters as rasters,
)
from lgmd2jax._eye import Eye as Eye
from lgmd2jax._handover.model_file import load as load, save as save
from lgmd2jax._network.ablation import ABLATIONS as ABLATIONS, ablate as ablate
from lgmd2jax._network.abstract import Network as Network, Response as Response, State as State
from lgmd2jax._network.frame_rate import at_frame_rate as at_frame_rate
from lgmd2jax._network.lgmd2 import LGMD2 as LGMD2
from lgmd2jax._network.parameters import (
    PRESETS as PRESETS,
    Parameters as Parameters,
    Symbol as Symbol,
    preset as preset,
    symbols as symbols,
)
from lgmd2jax._network.pixels import Layers as Layers
from lgmd2jax._network.thresholds import (
    Hard as Hard,
    Soft as Soft,
    StraightThrough as StraightThrough,
    Thresholds as Thresholds,
    Widths as Widths,
)
from lgmd2jax._network.yue_rind import (
    YueRindLayers as YueRindLayers,
    YueRindLGMD1 as YueRindLGMD1,
    YueRindParameters as YueRindParameters,
)
from lgmd2jax._protocol.protocol import Condition as Condition, Protocol as Protocol, load_protocol as load_protocol
from lgmd2jax._recipes.fit import Recipe as Recipe
from lgmd2jax._recipes.load import load_recipe as load_recipe
from lgmd2jax._recipes.sweep import SweepRecipe as SweepRecipe
from lgmd2jax._results.fit_folder import load_fit as load_fit, save_fit as save_fit
from lgmd2jax._sweep import surfaces as surfaces, sweep as sweep
from lgmd2jax._targets.csv_files import read_spike_trains as read_spike_trains, read_target as read_target
from lgmd2jax._targets.looming_law import LoomingLaw as LoomingLaw
from lgmd2jax._targets.model_target import ModelTarget as ModelTarget
from lgmd2jax._targets.observation import Observation as Observation, observation_symbols as observation_symbols
from lgmd2jax._targets.rest import Onset as Onset, Rest as Rest
from lgmd2jax._targets.spike_trains import SpikeTrains as SpikeTrains, spike_rate as spike_rate
from lgmd2jax._targets.target import Target as Target
from lgmd2jax._targets.weighted import Weighted as Weighted
from lgmd2jax.fitting import (
    Fit as Fit,
    Free as Free,
    Linear as Linear,
    Log as Log,
    Tie as Tie,
    fit as fit,
)
from lgmd2jax.stimuli import Stimulus as Stimulus
